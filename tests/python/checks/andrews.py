"""Andrews' squeezing mechanism: seven bodies, a spring, a constant torque."""

from math import cos, sin

import rustchain as rc

# β, Θ, γ, Φ, δ, Ω, ε [rad] at the start and at 0.03 s: test set for initial value problem solvers.
START = (
    -0.06171389001427645,
    0.0,
    0.4552798191630704,
    0.22266839016588588,
    0.48736497954384256,
    -0.22266839016588588,
    1.2305474445498212,
)
END = (
    15.81077119629904,
    -15.75637105984298,
    0.04082224013073101,
    -0.5347301163226948,
    0.5244099658805304,
    0.5347301163226948,
    1.048080741042263,
)
A, B, C = (-0.06934, -0.00227), (-0.03635, 0.03273), (0.014, 0.072)  # fixed points [m]
MASSES = (0.04325, 0.00365, 0.02373, 0.00706, 0.07050, 0.00706, 0.05498)
INERTIAS = (2.194e-6, 4.410e-7, 5.255e-6, 5.667e-7, 1.169e-5, 5.667e-7, 1.912e-5)


def andrews():
    """Return the mechanism (Schiehlen 1990; Hairer and Wanner 1996) and its angles at 0.03 s.

    Points are in the frames of the bodies, their origins at the centres of mass.
    """
    beta, theta, gamma, phi, delta, omega, epsilon = START
    angles = (beta, beta + theta, gamma, phi + delta, delta, omega + epsilon, epsilon)
    a1, a2, a3, a4, a5, a6, a7 = angles
    centers = (
        (92e-5 * cos(a1), 92e-5 * sin(a1)),
        (7e-3 * cos(a1) - 115e-4 * cos(a2), 7e-3 * sin(a1) - 115e-4 * sin(a2)),
        (
            B[0] + 1874e-5 * sin(a3) + 1043e-5 * cos(a3),
            B[1] - 1874e-5 * cos(a3) + 1043e-5 * sin(a3),
        ),
        (A[0] + 4e-2 * cos(a5) + 579e-5 * sin(a4), A[1] + 4e-2 * sin(a5) - 579e-5 * cos(a4)),
        (A[0] + 2308e-5 * cos(a5) - 916e-5 * sin(a5), A[1] + 2308e-5 * sin(a5) + 916e-5 * cos(a5)),
        (A[0] + 4e-2 * sin(a7) + 579e-5 * cos(a6), A[1] - 4e-2 * cos(a7) + 579e-5 * sin(a6)),
        (A[0] + 1228e-5 * sin(a7) - 449e-5 * cos(a7), A[1] - 1228e-5 * cos(a7) - 449e-5 * sin(a7)),
    )
    m = rc.Mechanism(gravity=(0.0, 0.0))
    for k in range(7):
        m.add_body(f"K{k + 1}", MASSES[k], INERTIAS[k], (*centers[k], angles[k]))
    k2_end = (115e-4 - 28e-3, 0.0)

    def k3(x, y):
        return x - 1043e-5, y + 1874e-5

    def k7(x, y):
        return x + 449e-5, y + 1228e-5

    for name, one, point, other, other_point in (
        ("O", "ground", (0.0, 0.0), "K1", (-92e-5, 0.0)),
        ("F", "K1", (7e-3 - 92e-5, 0.0), "K2", (115e-4, 0.0)),
        ("E3", "K2", k2_end, "K3", k3(0.0, -35e-3)),
        ("E4", "K2", k2_end, "K4", (0.0, -1421e-5)),
        ("E6", "K2", k2_end, "K6", (1421e-5, 0.0)),
        ("B", "ground", B, "K3", k3(0.0, 0.0)),
        ("G", "K4", (0.0, 579e-5), "K5", (4e-2 - 2308e-5, -916e-5)),
        ("A5", "ground", A, "K5", (-2308e-5, -916e-5)),
        ("H", "K6", (-579e-5, 0.0), "K7", k7(0.0, -4e-2)),
        ("A7", "ground", A, "K7", k7(0.0, 0.0)),
    ):
        m.add_revolute(name, one, other, point, other_point)
    ends = {"point_a": C, "point_b": k3(2e-2, -18e-3)}
    m.add_spring("spring", "ground", "K3", 4530.0, rest_length=7785e-5, **ends)
    m.add_torque("torque", "K1", 0.033)
    return m, END
