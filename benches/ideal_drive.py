"""Drives with ideal hinges beside the same drives with clearance: time, steps and energy residual.

ANSI 40, 17 and 25 teeth, 1500 rpm, 5 N m of load. One line for each length of the chain, method and
kind of hinges; processor time of one run.
"""

import argparse
import time

import rustchain as rc
from practical import drive

REPORT_STEP = 1e-4


def row(links, hinges, method, duration):
    """Return counts and times of a run of `duration` [s] as a row of the table."""
    simulation = rc.Simulation(drive(links=links, hinges=hinges)(), solver=rc.Solver(method))
    begin = time.process_time()
    result = simulation.run(duration, report_step=REPORT_STEP, progress=False)
    spent = time.process_time() - begin
    stats, energy = result.stats, result.energy
    return (
        f"| {links} | {hinges} | {method} | {stats['steps'] / duration:.3g} "
        f"| {stats['rejected'] / stats['steps']:.3f} | {stats['evaluations'] / stats['steps']:.2f} "
        f"| {1e6 * spent / stats['steps']:.1f} | {spent / duration:.1f} "
        f"| {abs(energy.residual).max() / energy.dissipated[-1]:.1e} |"
    )


def main():
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--test", action="store_true", help="leave out the long chains")
    lengths = (60,) if parser.parse_args().test else (60, 150, 614)
    print(
        "| links | hinges | method | steps a second | rejected a step | evaluations a step "
        "| time a step [µs] | time a second [s] | residual over dissipated |"
    )
    print("|---|---|---|---|---|---|---|---|---|")
    for links in lengths:
        duration = 0.02 * 60 / links
        for hinges in ("clearance", "ideal"):
            for method in ("auto", "newton"):
                print(row(links, hinges, method, duration), flush=True)


if __name__ == "__main__":
    main()
