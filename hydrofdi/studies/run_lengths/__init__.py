"""How long a leak that sets in during operation goes unnoticed, and how often healthy records alarm.

Control charts see scores along the time; here alone do their alarms meet what is known of the records.
"""
