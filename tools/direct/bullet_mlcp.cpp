// Bullet's solvers of mixed LCPs, in the plane, as an executable that frictionbench calls (docs/executable.md):
//
//     apt-get install libbullet-dev
//     c++ -O2 -DBT_USE_DOUBLE_PRECISION -I/usr/include/bullet -o bullet_mlcp tools/direct/bullet_mlcp.cpp -lBulletDynamics-float64 -lLinearMath-float64
//     frictionbench solve 'pyramid[rows=3,push=1]' --solver 'exec:./bullet_mlcp pgs {problem} {answer}' --solver nsgs
//
// pgs: projected Gauss-Seidel sweeps, whose friction bounds follow the current normal impulses. dantzig: its bounds are those of the
// frictionless normal impulses, another law than Coulomb's. Its Lemke method is called through the same interface, which has
// no bounds that depend on other unknowns, so friction is left out there; btLemkeAlgorithm itself takes the friction LCP. The clock is
// around solveMLCP.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <fstream>
#include <iostream>
#include <string>
#include <vector>
#include "BulletDynamics/MLCPSolvers/btDantzigSolver.h"
#include "BulletDynamics/MLCPSolvers/btSolveProjectedGaussSeidel.h"

static double number(std::istream &file, const std::string &name) {
    std::string found;
    double value;
    if (!(file >> found >> value) || found != name) {
        std::cerr << "expected " << name << ", found " << found << "\n";
        exit(1);
    }
    return value;
}

static std::vector<double> numbers(std::istream &file, const std::string &name) {
    std::vector<double> values(size_t(number(file, name)));
    for (double &value : values) file >> value;
    return values;
}

int main(int argc, char **argv) {
    const std::string method = argc == 4 ? argv[1] : "";
    std::ifstream file(argc == 4 ? argv[2] : "");
    if (!file || (method != "pgs" && method != "dantzig")) return 1;
    number(file, "tolerance");
    const double tolerance = number(file, "velocity_tolerance");
    const int limit = int(number(file, "limit")), d = int(number(file, "dimension")), nc = int(number(file, "contacts")), n = 2 * nc;
    if (d != 2) {
        std::cerr << "contacts in the plane only\n";
        return 1;
    }
    number(file, "velocities");
    number(file, "joints");
    const std::vector<double> mu = numbers(file, "friction");
    for (double bias : numbers(file, "friction_bias"))
        if (bias != 0) {
            std::cerr << "no friction bias\n";
            return 1;
        }
    btMatrixXu A(n, n);
    A.setZero();
    for (int k = int(number(file, "W")); k > 0; k--) {
        int i, j;
        double value;
        file >> i >> j >> value;
        A.setElem(i, j, value);
    }
    const std::vector<double> q = numbers(file, "q");
    btVectorXu b(n), x(n), lo(n), hi(n);
    btAlignedObjectArray<int> normal; // of a tangent, whose bounds are lo and hi times its impulse
    normal.resize(n);
    for (int i = 0; i < n; i++) {
        const bool tangent = i % 2;
        b[i] = -q[i], x[i] = 0;
        lo[i] = tangent ? -mu[i / 2] : 0, hi[i] = tangent ? mu[i / 2] : BT_INFINITY;
        normal[i] = tangent ? i - 1 : -1;
    }
    btSolveProjectedGaussSeidel sweeps;
    double largest = 0;
    for (int i = 0; i < n; i++) largest = std::max(largest, double(A(i, i)));
    const double change = tolerance / (10 * largest); // of an impulse in a sweep, as small as a tenth of the tolerance
    sweeps.m_leastSquaresResidualThreshold = change * change;
    btDantzigSolver dantzig;
    btMLCPSolverInterface &solver = method == "pgs" ? (btMLCPSolverInterface &)sweeps : dantzig;
    const auto begun = std::chrono::steady_clock::now();
    const bool solved = solver.solveMLCP(A, b, x, lo, hi, normal, limit ? limit : 20000);
    const double clock = std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();

    std::ofstream answer(argv[3]);
    answer.precision(17);
    answer << "status " << (solved ? "solved" : "failed") << "\nclock " << clock << "\nimpulse\n";
    for (int i = 0; i < nc; i++) answer << x[2 * i] << " " << x[2 * i + 1] << "\n";
    return answer ? 0 : 1;
}
