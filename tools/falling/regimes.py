"""How a plate falls under the equations of Andersen, Pesavento & Wang (J. Fluid Mech. 541, 2005, 91-104), by
inertia and coefficients: in goes nothing, out comes a line for each set of coefficients.

A second implementation, of its own: `src/scene/fall/plate.rs` keeps the chord's direction as cosine and
sine, this an angle. Letters: F flutter, T tumble, x anything else (chaotic, or a swing of more than half
a turn); one for each I*, from 0.1 on in steps of 0.05. Lengths are in half chords, speeds in sqrt(2
areal_mass g / (pi air_density)).

    python tools/falling/regimes.py
"""

import numpy as np

STEP, SETTLED, END = 0.02, 160.0, 400.0
INERTIA = np.arange(0.1, 2.001, 0.05)
# Belmonte, Eisenberg & Moses, Phys. Rev. Lett. 81 (1998) 345: Fr = sqrt(areal_mass / (air_density
# chord)) = 0.67 +- 0.05.
BELMONTE = [4.0 * froude**2 / np.pi for froude in (0.62, 0.67, 0.72)]
# C_T, C_R, A, B, mu_1, mu_2
PAPER = (1.2, np.pi, 1.4, 1.0, 0.2, 0.2)
SETS = {
    "the paper's": PAPER,
    "C_T 2": (2.0, *PAPER[1:]),
    "A 1, B 0.6": (1.2, np.pi, 1.0, 0.6, 0.2, 0.2),
    "mu_1 0": (1.2, np.pi, 1.4, 1.0, 0.0, 0.2),
    "mu_1, mu_2 0.05": (1.2, np.pi, 1.4, 1.0, 0.05, 0.05),
    "C_R 2.2": (1.2, 2.2, 1.4, 1.0, 0.2, 0.2),
    "C_R 1.6": (1.2, 1.6, 1.4, 1.0, 0.2, 0.2),
    "C_R 2.2, mu_1 0, mu_2 0.1": (1.2, 2.2, 1.4, 1.0, 0.0, 0.1),
    "C_R 1.6, mu_1 0, mu_2 0.1": (1.2, 1.6, 1.4, 1.0, 0.0, 0.1),
    "C_T 1.8, C_R 2.2, mu 0.05": (1.8, 2.2, 1.4, 1.0, 0.05, 0.05),
}


def rates(state, inertia, coefficients):
    """Equations (4.7)-(4.9) and (5.1)-(5.3)."""
    u, v, w, angle = state[:4]
    c_t, c_r, a, b, mu_1, mu_2 = coefficients
    speed = np.hypot(u, v)
    over_speed = np.where(speed > 0, 1 / np.where(speed > 0, speed, 1), 0)
    circulation = 2 / np.pi * (-c_t * u * v * over_speed + c_r * w)
    drag = (a * speed - b * (u * u - v * v) * over_speed) / np.pi
    sin, cos = np.sin(angle), np.cos(angle)
    return np.array([
        ((inertia + 1) * w * v - circulation * v - sin - drag * u) / inertia,
        (-inertia * w * u + circulation * u - cos - drag * v) / (inertia + 1),
        (-u * v - (mu_1 + mu_2 * abs(w)) * w) / (0.25 * (inertia + 0.5)),
        w,
        u * sin + v * cos,
    ])


def falls(coefficients):
    """Of each inertia: the regime's letter, and the speed with which it sinks."""
    state = np.zeros((5, len(INERTIA)))
    state[3] = np.pi / 4
    settled = None
    for number in range(int(END / STEP)):
        if settled is None and number * STEP >= SETTLED:
            settled, low, high = state.copy(), state[3].copy(), state[3].copy()
            turned_back = np.zeros(len(INERTIA), int)
        k1 = rates(state, INERTIA, coefficients)
        k2 = rates(state + STEP / 2 * k1, INERTIA, coefficients)
        k3 = rates(state + STEP / 2 * k2, INERTIA, coefficients)
        k4 = rates(state + STEP * k3, INERTIA, coefficients)
        before, state = state, state + STEP / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
        if settled is not None:
            low, high = np.minimum(low, state[3]), np.maximum(high, state[3])
            turned_back += before[2] * state[2] < 0
    turns = abs(state[3] - settled[3]) / (2 * np.pi)
    is_flutter = high - low < np.pi
    is_tumble = (turned_back == 0) | ((turns > 5) & (turned_back < 4))
    return np.where(is_flutter, "F", np.where(is_tumble, "T", "x")), (settled[4] - state[4]) / (END - SETTLED)


def main():
    print(
        "flutter ends at I* = {:.2f} to {:.2f} ({:.2f}) for Belmonte's strips".format(
            BELMONTE[0], BELMONTE[2], BELMONTE[1]
        )
    )
    print(f"{'':28}{'last flutter':>13}{'sinks at 0.4':>14}{'regimes from I* = 0.1':>24}")
    for name, coefficients in SETS.items():
        letters, sinks = falls(coefficients)
        others = np.flatnonzero(letters != "F")
        last = f"{INERTIA[others[0] - 1]:.2f}" if len(others) and others[0] else "none"
        print(f"{name:28}{last:>13}{sinks[np.argmin(abs(INERTIA - 0.4))]:14.2f}   {''.join(letters)}")


if __name__ == "__main__":
    main()
