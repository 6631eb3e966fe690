"""What a warm start buys: recorded motions replayed from zero, from the step before, and from another step."""

from frictionbench.harness.plans.plan import Plan, Source
from frictionbench.harness.plans.suites import EXAMPLES
from frictionbench.harness.studies.study import Study
from frictionbench.results.conventions import COLD, SHUFFLED, WARM

SOLVERS = ("lemke", "interior_point", "nsgs", "staggered", "nncg", "anitescu_hart", "apgd_coulomb", "admm_coulomb")
PILES = (
    Source("stack", {"blocks": 5, "push": 0.5}, pick=8, steps=60, repeats=1),
    Source("pyramid", {"rows": 3, "push": 0.2}, pick=8, steps=60, repeats=1),
    Source("disc_pile", {"rows": 4}, pick=8, steps=60, repeats=1),
    Source("arch", {}, pick=8, steps=60, repeats=1),
)


def plan() -> Plan:
    """Problems of the seven examples and of piles, each solved from three starts; times are not used, so each is taken once."""
    return Plan(
        suite="study warm",
        sources=(*(Source(name, pick=8, steps=150, repeats=1) for name in EXAMPLES), *PILES),
        solvers=SOLVERS,
        tolerances=(1e-8,),
        starts=(COLD, WARM, SHUFFLED),
        time_limit=10.0,
    )


STUDY = Study(
    name="warm",
    question="What does warm starting buy?",
    method="""Eight problems spread over each of eleven motions, the seven examples and four piles, recorded with verified
    answers, are solved to 1e-8 from zero, from the answer of the problem before, and, as a control, from that of another step
    of the same motion, transferred contact by contact. Only problems with all three starts are compared, and of each method
    those that it solves from all three. The measure is the method's own deterministic count, not time: the sum of the counts
    from a start over the sum from zero. Intervals are by resampling the motions.""",
    plan=plan,
)
