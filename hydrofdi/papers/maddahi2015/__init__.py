"""The study of Maddahi et al., CDSR 2015, paper 181: leakage over the effective bulk modulus (EBM)."""

from hydrofdi.papers.maddahi2015.claims import CLAIMS, Claim, ClaimResult
from hydrofdi.papers.maddahi2015.report import StudyReport
from hydrofdi.papers.maddahi2015.study import Study, is_study, study_experiment

__all__ = ["CLAIMS", "Claim", "ClaimResult", "Study", "StudyReport", "is_study", "study_experiment"]
