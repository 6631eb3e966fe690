"""One time step of rigid bodies in contact with Coulomb friction.

In velocities v (nv) and contact impulses r (nc*d, per contact the normal first), with J the contact Jacobian,

    M (v - v*) = J' r + F' lam,      F v + b_F = 0,      u = J v + b,

Coulomb's law relates the impulse of each contact to its velocity u = (u_n, u_t), where b acts on u_n alone:

    0 <= u_n  ⟂  r_n >= 0,      |r_t| <= mu r_n + b_f,      r_t opposes u_t with |r_t| = mu r_n + b_f wherever u_t != 0.

Eliminating v and lam leaves the Delassus form u = W r + q (problems.mechanics).
References: Anitescu and Potra 1997; Acary and Brogliato 2008, chapter 10.
"""

from functools import cached_property
from typing import Any, ClassVar

import numpy as np

from frictionbench.problems import check, sizes
from frictionbench.problems.check import Array, counted, require
from frictionbench.problems.forms import delassus
from frictionbench.problems.forms.balance import delassus_parts
from frictionbench.problems.forms.definite import FILE_ROUNDING, LARGEST_INPUT, require_semidefinite
from frictionbench.problems.forms.islands import delassus_graph, delassus_units, islands
from frictionbench.problems.forms.joints import require_consistent
from frictionbench.problems.forms.lcp import LCP, content_hash, friction_rows, tangent_basis
from frictionbench.problems.forms.mass import inverse_mass
from frictionbench.problems.forms.relaxation import Program, relaxation
from frictionbench.problems.mechanics import NO_ROWS, Measures, Mechanics
from frictionbench.problems.rows import ByContact, Index64, Rows, by_contact


class FrictionProblem(Mechanics):
    """A friction problem with nc contacts of dimension d (2 planar, 3 spatial) and nv velocities.

    mass: (nv, nv), symmetric positive definite. normal: (nc, nv). tangent: (nc*(d-1), nv), rows per contact.
    friction: (nc,), >= 0. free_velocity: (nv,), the velocity without any constraint.
    bias: (nc,), m/s, added to the normal velocity: gap/step, or a restitution target.
    friction_bias: (nc,), N s, >= 0: friction available without a normal impulse of this step (Poisson's decompression).
    joints: (nj, nv), joint_bias: (nj,), m/s: bilateral constraints, of any rank, satisfied exactly.

    Joint limits and dry friction in joints are represented as contacts, in rad/s and N m s if the joint's coordinate is an
    angle. For a limit, T = 0 and mu = 0; N is its direction and b is the gap divided by the step. For dry friction, N = 0 and
    mu = 0; the first row of T is its direction and b_f is the step times the friction force. Its b may be any positive number,
    by convention 1, so that r_n = 0. That b is not a velocity, and the units of residuals do not depend on it.

    Everything is checked, copied and made read-only here. Errors: InputError naming the field.

    >>> import frictionbench as fb
    >>> point = fb.FrictionProblem(  # a point of 2 kg that slides on the floor and falls onto it at 0.1 m/s
    ...     mass=[[2.0, 0.0], [0.0, 2.0]],
    ...     normal=[[0.0, 1.0]],
    ...     tangent=[[1.0, 0.0]],
    ...     friction=[0.5],
    ...     free_velocity=[1.0, -0.1],
    ...     bias=[0.0],
    ... )
    >>> fb.solve(point, "lemke").impulse.round(6).tolist()
    [[0.2, -0.1]]
    """

    FIELDS: ClassVar[tuple[str, ...]] = (  # the defining fields, in the order of the content hash
        *("mass", "normal", "tangent", "friction", "free_velocity", "bias", "friction_bias", "joints", "joint_bias"),
    )

    def __init__(
        self,
        *,
        mass: Any,
        normal: Any,
        tangent: Any,
        friction: Any,
        free_velocity: Any,
        bias: Any,
        friction_bias: Any = None,
        joints: Any = None,
        joint_bias: Any = None,
        dimension: int = 2,
    ) -> None:
        require(_is_dimension(dimension), "dimension", f"must be 2 or 3, got {dimension!r:.100}")
        sizes.agree(dimension, locals())
        mu, b_f = _law(friction, friction_bias)
        v = check.vector("free_velocity", free_velocity)
        nc, nv = len(mu), len(v)
        joint_rows = NO_ROWS if joints is None else check.rows("joints", joints, (None, nv))
        nj = len(joint_rows.start) - 1
        mass_rows = check.rows("mass", mass, (nv, nv))
        normal_rows = check.rows("normal", normal, (nc, nv))
        tangent_rows = check.rows("tangent", tangent, (nc * (dimension - 1), nv))
        vars(self).update(
            dimension=dimension,
            friction=mu,
            friction_bias=b_f,
            free_velocity=v,
            bias=check.vector("bias", bias, nc),
            joint_bias=check.vector("joint_bias", np.zeros(nj) if joint_bias is None else joint_bias, nj),
            contact_rows=by_contact(normal_rows, tangent_rows, dimension),
            joint_rows=joint_rows,
            mass_rows=mass_rows,
            inverse_rows=inverse_mass(mass_rows),
        )
        if nj:
            require_consistent(self._held, self.joints, self.joint_bias, self.inverse_mass.diagonal(), v)

    @staticmethod
    def from_delassus(W: Any, q: Any, friction: Any, d: int, friction_bias: Any = None) -> "FrictionProblem":
        """The problem given by W and q in u = W r + q alone; rows per contact, normal first (FCLIB's order).

        W: (nc*d, nc*d), 1/kg, with a positive semidefinite symmetric part. W may be unsymmetric: `asymmetry` and the summary
        state by how much, and methods that work in velocities then refuse the problem. q: (nc*d,), m/s. friction: (nc,).
        Errors: InputError naming the field.

        >>> import frictionbench as fb
        >>> fb.FrictionProblem.from_delassus([[0.5, 0.0], [0.0, 0.5]], [-0.1, 1.0], [0.5], d=2).contacts
        1
        """
        return GivenDelassus(W, q, friction, d, friction_bias)

    def replace(self, **changes: Any) -> "FrictionProblem":
        """The same problem with some of its fields changed. Errors: InputError naming the field."""
        fields = {name: getattr(self, name) for name in self.FIELDS} | changes
        if self.mechanical:
            return FrictionProblem(dimension=self.dimension, **fields)
        return GivenDelassus(d=self.dimension, **fields)

    @property
    def mechanical(self) -> bool:
        """Whether the masses and Jacobians are given; otherwise only W and q are."""
        return True

    def lcp(self, facets: int = 8) -> LCP:
        """The friction LCP of nc (K + 2) unknowns (problems.forms.lcp). Exact in the plane, where K = 2.

        In space the cone's section is an inscribed polygon with K = facets corners.
        Errors: InputError naming facets if it is odd or less than 4.
        """
        basis = tangent_basis(self.dimension, facets)
        *rows, right = friction_rows(*self.blocks, self.q, self.friction, self.friction_bias, basis)
        return LCP.of_friction(Rows(*rows), right, basis, (self.contacts, self.dimension))

    def qp(self, facets: int = 8) -> Program:
        """The convex relaxation as a quadratic program in the velocities (Anitescu 2006).

        min 1/2 x'Px + q'x with h - G x >= 0 and A x = b, matrices in CSC form. In space the cone's section is a polygon with
        `facets` corners; in the plane facets has no effect.
        """
        corners = tangent_basis(self.dimension, facets)[1:, 1:].T
        return relaxation(self, np.column_stack([np.ones(len(corners)), corners]))

    def cone(self) -> Program:
        """The convex relaxation as a second-order cone program in the velocities (Anitescu and Tasora 2010).

        min 1/2 x'Px + q'x with h - G x in second-order cones {s_0 >= |s_1:|}, one block of d rows for each, and A x = b.
        """
        return relaxation(self, np.eye(self.dimension))

    @cached_property
    def hash(self) -> str:
        """Content hash: equal for equal problems, whatever form the fields were given in."""
        return content_hash(dimension=self.dimension, **{name: getattr(self, name) for name in self.FIELDS})

    @property
    def summary(self) -> str:
        """The size in words, for example: 9 contacts in space, 40 joint equations, 54 velocities."""
        size = [f"{counted(self.contacts, 'contact')} in {'the plane' if self.dimension == 2 else 'space'}"]
        if not self.mechanical:
            off = self.asymmetry
            return f"{size[0]}, known by W" + (f", unsymmetric by {off:.1g}" if off > FILE_ROUNDING else "")
        if len(self.joint_bias):
            size.append(counted(len(self.joint_bias), "joint equation"))
        return ", ".join([*size, counted(len(self.free_velocity), "velocity")])

    def __repr__(self) -> str:
        return f"FrictionProblem({self.summary})"


class GivenDelassus(FrictionProblem):
    """A problem given by W (nc*d, nc*d) and q (nc*d,) alone, rows per contact, normal first.

    W is stored as given. It may be unsymmetric, because of gyroscopic or follower forces, or slightly indefinite, as in
    recorded problems (problems.forms.definite). The problem has nc*d velocities, unit mass and a dense Jacobian J, for which
    J J' is W's symmetric part. J is computed only when a method asks for it.
    """

    DEFINED_BY = (*Mechanics.DEFINED_BY[:-1], "W", "blocks", "q")
    FIELDS = ("W", "q", "friction", "friction_bias")

    def __init__(self, W: Any, q: Any, friction: Any, d: int, friction_bias: Any = None) -> None:
        require(_is_dimension(d), "d", f"must be 2 or 3, got {d!r:.100}")
        sizes.agree(d, locals(), {"dimension": "d"})
        mu, b_f = _law(friction, friction_bias)
        n = len(mu) * d
        vector, matrix = check.vector("q", q, n), check.matrix("W", W, (n, n))
        require_semidefinite("W", matrix)
        identity = Rows(np.arange(n + 1, dtype=np.int32), np.arange(n, dtype=np.int32), np.ones(n))
        vars(self).update(
            dimension=d,
            friction=mu,
            friction_bias=b_f,
            mass_rows=identity,
            inverse_rows=identity,
            joint_rows=NO_ROWS,
            free_velocity=check.vector("free_velocity", np.zeros(n)),
            bias=check.vector("q", vector[::d]),
            joint_bias=check.vector("joint_bias", np.zeros(0)),
            W=matrix,
            blocks=delassus.blocks(matrix, d),
            q=vector,
        )

    @property
    def mechanical(self) -> bool:
        return False

    @cached_property
    def asymmetry(self) -> float:
        return float(abs(self.W - self.W.T).max() / abs(self.W).max()) if self.W.nnz else 0.0

    @cached_property
    def offset(self) -> Array:
        return self.q.reshape(-1, self.dimension)

    def _measured(self, mu: Array) -> Measures:
        scale, units, unlike = delassus.known_measures(*self.blocks, self.q, self.friction_bias, mu)
        units.setflags(write=False)
        return self.q, scale, float(delassus.largest(self.q, self.dimension)), units, float(unlike)

    def _units_at(self, q: Array, scale: Array) -> tuple[Array, Index64]:
        return delassus_units(*self.blocks, q, scale, self.friction_bias)

    @cached_property
    def islands(self) -> Index64:
        return islands(*delassus_graph(*self.blocks, self.scale))

    def _over(self, factor: Array) -> dict[str, Array]:
        return {"q": self.q / np.repeat(factor, self.dimension)}

    @cached_property
    def parts(self) -> Index64:
        return delassus_parts(*self.blocks[:2])

    def contact_velocity(self, impulse: Array) -> Array:
        return delassus.act(*self.blocks, self._by_contact(impulse), self.offset, False)

    def velocity_size(self, impulse: Array) -> Array:
        return delassus.act(*self.blocks, self._by_contact(impulse), self.offset, True)

    @cached_property
    def contact_rows(self) -> ByContact:  # type: ignore[override]
        """J (nc*d, nc*d), where J J' is the symmetric part of W. J is dense, but its columns for W's null space are empty."""
        value, basis = np.linalg.eigh((self.W + self.W.T).toarray() / 2)
        floor = np.finfo(float).eps * len(value) * abs(value).max(initial=0.0)
        root = (basis * np.sqrt(np.where(value > floor, value, 0.0))).reshape(self.contacts, self.dimension, len(value))
        touched = np.asarray(root.any(axis=1))
        start = np.append(0, touched.sum(axis=1).cumsum()).astype(np.int32)
        return ByContact(start, np.nonzero(touched)[1].astype(np.int32), root.transpose(0, 2, 1)[touched])


def _is_dimension(value: object) -> bool:
    return isinstance(value, int | np.integer) and value in (2, 3)


def _law(friction: Any, friction_bias: Any) -> tuple[Array, Array]:
    """The checked coefficients mu and friction biases (nc,); a friction_bias of None stands for zeros."""
    mu = check.vector("friction", friction)
    bias = check.vector("friction_bias", np.zeros(len(mu)) if friction_bias is None else friction_bias, len(mu))
    for name, values in (("friction", mu), ("friction_bias", bias)):
        require(not (values < 0).any(), name, "must not be negative")
        require(not (values >= LARGEST_INPUT).any(), name, f"must be below {LARGEST_INPUT:g}")
    return mu, bias


def require_problem(problem: object) -> None:
    """Errors: InputError naming `problem` if it is neither a friction problem nor an LCP."""
    got = f"{type(problem)}" + "; its method problem() makes one" * hasattr(problem, "problem")
    require(isinstance(problem, FrictionProblem | LCP), "problem", f"must be a FrictionProblem or an LCP, got {got}")
