"""The lists of `frictionbench list`: JSON, or a paragraph for each scene, solver or suite, wrapped to the terminal's width."""

from dataclasses import fields
from itertools import groupby
from typing import Any

from frictionbench.commands.table import say
from frictionbench.harness.plans.suites import SUITES
from frictionbench.problems.catalogue import instances, scenes
from frictionbench.results.conventions import number
from frictionbench.solvers import available, find
from frictionbench.solvers.plugins import distribution, installed

SPACES = {2: "planar", 3: "spatial", (2,): "planar", (3,): "spatial", (2, 3): "planar and spatial"}
Facts = dict[str, Any]


def listed(what: str) -> dict[str, Facts]:
    """Return the scenes, solvers or suites by name, each with its summary and facts."""
    return {"scenes": _scenes, "solvers": _solvers, "suites": _suites}[what]()


def show(what: str) -> None:
    """Print each name with its short facts in brackets, and below it the summary and the facts that are lists."""
    for name, entry in listed(what).items():
        facts = {fact.replace("_", " "): value for fact, value in entry.items() if value and value != [name]}
        texts = [facts.pop("summary", "No description.")]
        texts += [f"{fact}: {_words(fact, value)}" for fact, value in facts.items() if isinstance(value, dict | list)]
        short = [_short(fact, value) for fact, value in facts.items() if not isinstance(value, dict | list)]
        say(f"{name}  ({'; '.join(short)})" if short else name, rest="    ")
        for text in texts:
            say(text, "    ")


def _short(fact: str, value: Any) -> str:
    if fact == "dimension":
        return SPACES[value]
    return fact if value is True else f"not available: {value}" if fact == "missing" else f"{fact} {value}"


def _words(fact: str, values: Facts | list[Any]) -> str:
    if isinstance(values, dict):
        return ", ".join(f"{name}={_number(value)}" for name, value in values.items())
    if fact != "solvers":
        return ", ".join(map(_number, values))
    solvers = {name: list(variants) for name, variants in groupby(sorted(values), lambda spec: spec.partition("[")[0])}
    return ", ".join(f"{name} ({len(of)} variants)" if of[1:] else of[0] for name, of in solvers.items())


def _number(value: Any) -> str:
    return number(value, 4) if isinstance(value, float) else str(value)


def _scenes() -> dict[str, Facts]:
    made: dict[str, Any] = {**scenes(), **instances()}
    return {
        name: {
            "summary": one.summary
            + (f" Another name of {alias}." if (alias := one.make.__name__) in made.keys() - {name} else ""),
            "dimension": one.dimension,
            "one_step": name in instances(),
            "parameters": dict(one.parameters),
        }
        for name, one in made.items()
    }


def _solvers() -> dict[str, Facts]:
    """Return the solvers of this package and of loaded plug-ins, and installed plug-ins without importing their code."""
    solvers: dict[str, Facts] = {}
    for name, info in sorted(available().items()):
        made: Any = info.make()
        first = find(info.specs[0])[0]
        solvers[name] = {
            "summary": info.summary,
            "family": info.family,
            "model": info.model,
            "dimension": tuple(info.dimension),
            "takes_a_start": info.warm_start,
            "portfolio": bool(info.members),
            "single_precision": info.precision == "single",
            "version": "" if first.missing else first.version,
            "missing": info.missing,
            "settings": {each.name: getattr(made, each.name) for each in fields(made)},
            "variants": list(info.specs),
        }
    for name, point in installed().items():
        solvers[name] = {"summary": f"Installed plug-in: {point.value}.", "distribution": distribution(point)}
    return solvers


def _suites() -> dict[str, Facts]:
    suites = {}
    for name, make in SUITES.items():
        plan = make()
        facts = {"summary": " ".join((make.__doc__ or "").split()), "takes": plan.expects}
        suites[name] = facts | {"tolerances": list(plan.tolerances), "solvers": list(plan.variants)}
    return suites
