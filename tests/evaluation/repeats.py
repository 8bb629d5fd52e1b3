"""How often something happens in repeats with known truth, against what was promised."""

from scipy.stats import binom


def holds_in(count, repeats, probability):
    """Whether a count of successes is what the probability gives, but for one chance in a thousand."""
    low, high = binom.interval(0.999, repeats, probability)
    return low <= count <= high


def holds_at_least(count, repeats, probability):
    return count >= binom.ppf(0.001, repeats, probability)
