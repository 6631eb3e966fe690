"""What a run's problems are made of: sizes, contacts that stick, slide and open, and the weights that keep families equal."""

import pandas as pd

EDGES = (0, 1, 10, 100, float("inf"))  # contacts: bands of sizes up to and including the upper edge
BANDS = ("1", "2 to 10", "11 to 100", "over 100")


def bands(contacts: "pd.Series[int]") -> "pd.Series[str]":
    """The band of sizes of each problem, ordered from 1 contact to over 100."""
    return pd.cut(contacts, list(EDGES), labels=list(BANDS))


def mix(solves: pd.DataFrame) -> pd.DataFrame:
    """For each dimension and band of sizes: the number of problems and of scenes, and the shares of contacts that stick, slide
    and are open in the reference answers.

    solves: rows of the table of solves, any number of each problem. Each problem counts as much as another, whatever its number
    of contacts; those without contacts or a reference answer count in no share.
    """
    problems = solves[solves["contacts"] > 0].drop_duplicates(["scene", "parameters", "step", "phase"])
    counts = problems[["sticking", "sliding", "open"]].astype(float)
    shares = counts.div(problems["contacts"].astype(float), axis=0)
    facts = shares.assign(problem=1, scene=problems["scene"], dimension=problems["dimension"], size=bands(problems["contacts"]))
    grouped = facts.groupby(["dimension", "size"], observed=True)
    return grouped.agg(
        problems=("problem", "sum"),
        scenes=("scene", "nunique"),
        sticking=("sticking", "mean"),
        sliding=("sliding", "mean"),
        open=("open", "mean"),
    )


def weights(problems: pd.DataFrame) -> "pd.Series[float]":
    """A weight for each problem, by its scene and band of sizes: all pairs of a scene and a band weigh 1, however many problems
    each has."""
    return 1.0 / problems.groupby(["scene", bands(problems["contacts"])], observed=True)["scene"].transform("size")
