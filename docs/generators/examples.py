"""Examples of every command. A test parses each line as the command line does."""

EXAMPLES = {
    "simulate": """\
hydrofdi simulate
hydrofdi simulate --set leakage.internal_flow='0.2 L/min' --set record.duration='4 s' --figure leak.png
hydrofdi simulate mine.yaml --out run.h5
""",
    "plan": """\
hydrofdi plan smoke
hydrofdi plan mine.yaml --set record.duration='40 s'
""",
    "sweep": """\
hydrofdi sweep smoke
hydrofdi sweep mine.yaml --out results/second --workers 4
hydrofdi sweep mine.yaml --retry-failed
""",
    "status": "hydrofdi status results/smoke\n",
    "report": """\
hydrofdi report
hydrofdi report results/smoke --format csv
hydrofdi report results/smoke --html smoke.html
hydrofdi report results/table3 --figure phases.png
""",
    "collect": "hydrofdi collect results/smoke\n",
    "verify": "hydrofdi verify results/smoke\n",
    "why": "hydrofdi why results/smoke 0\n",
    "rerun": "hydrofdi rerun results/smoke 0\n",
    "schema": """\
hydrofdi schema > experiment.schema.json
hydrofdi schema measured > measured.schema.json
""",
    "check": "hydrofdi check mine.yaml\n",
    "calibrate": "hydrofdi calibrate --flow '0.12 L/min' --flow '0.25 L/min'\n",
    "configs": """\
hydrofdi configs
hydrofdi configs delays
hydrofdi configs table3 > mine.yaml
""",
    "init": """\
hydrofdi init mine
hydrofdi init rig --from paper
""",
    "measure": """\
hydrofdi measure results/smoke --indicators dwt,ring_down
hydrofdi measure rig.csv --sampling-frequency '1 kHz' --out measured.csv
hydrofdi measure rig.csv --indicators detectors/weak-rls
""",
    "indicators": """\
hydrofdi indicators
hydrofdi indicators flow_balance
""",
    "inspect": """\
hydrofdi inspect rig.csv --sampling-frequency '1 kHz'
hydrofdi inspect rig.csv --figure rig.png
""",
    "diagnose": """\
hydrofdi diagnose today.csv --history healthy/
""",
    "evaluate": """\
hydrofdi evaluate rig.yaml --healthy sound --indicators dwt,ring_down
hydrofdi evaluate rig.yaml --false-alarm-rate '5 %'
""",
    "train": "hydrofdi train monitoring/healthy --config monitoring/windows --out detector.json\n",
    "detect": "hydrofdi detect detector.json today.csv --fail-on-alarm\n",
    "monitor": """\
hydrofdi monitor detector.json today.csv --state press.state
hydrofdi monitor fleet.yaml
hydrofdi monitor detector.json mqtts://broker.example/press/samples --state press.state
""",
    "replay": """\
hydrofdi replay monitoring/leak | hydrofdi monitor detector.json -
hydrofdi replay rig.csv --rate max
""",
    "trend": "hydrofdi trend press.jsonl --limit '0.5 L/min' --figure trend.png\n",
    "export": "hydrofdi export results/smoke --out signals\n",
}
