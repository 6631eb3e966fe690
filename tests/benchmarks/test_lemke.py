"""Time of Lemke's method on friction LCPs of 8 to 400 unknowns; where QuantEcon is installed its lcp_lemke runs beside it."""

import importlib

import pytest

from frictionbench.problems.random_problem import random_problem
from frictionbench.solvers.lemke import Lemke

CONTACTS = [2, 10, 20, 50, 100]


@pytest.mark.parametrize("contacts", CONTACTS)
def test_lemke(benchmark, contacts):
    lemke = Lemke()
    prepared = lemke.prepare(random_problem(contacts, contacts, friction=0.5))
    lemke.solve(prepared, 1e-8, None)  # compile
    answer = benchmark(lemke.solve, prepared, 1e-8, None)
    assert prepared[0].lcp.residual(answer.z) <= 1e-10


@pytest.mark.parametrize("contacts", CONTACTS)
def test_quantecon(benchmark, contacts):
    pytest.importorskip("quantecon")
    lcp_lemke = importlib.import_module("quantecon.optimize.lcp_lemke").lcp_lemke
    lcp = random_problem(contacts, contacts, friction=0.5).lcp()
    lcp_lemke(lcp.dense, lcp.q)
    answer = benchmark(lcp_lemke, lcp.dense, lcp.q)
    assert lcp.residual(answer.z) <= 1e-8
