"""The study of Maddahi et al., CDSR 2015, paper 181: leakage over the effective bulk modulus (EBM)."""
