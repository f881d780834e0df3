"""What a step of BlueSky costs: `python bluesky_steps.py COUNT SEED STEPS [conflicts]` prints microseconds of processor time a step.

Aircraft at random places and courses within 60 NM, FL100 to FL400, as in its own benchmark scenes; a step of 0.05 s of its simulation.
"""
import random
import sys
import time


def main() -> None:
    count, seed, steps = (int(a) for a in sys.argv[1:4])
    conflicts = "conflicts" in sys.argv[4:]
    import bluesky as bs

    bs.init(mode="sim", detached=True)
    # Nothing but its simulation: no messages of the commands.
    draws = random.Random(seed)
    for k in range(count):
        place = 52 + draws.uniform(-1, 1), 4 + draws.uniform(-1.6, 1.6)
        bs.traf.cre(f"T{k}", "A320", *place, draws.uniform(0, 360), draws.uniform(3000, 12000), 130 + draws.uniform(0, 100))
    bs.stack.stack("CDMETHOD STATEBASED" if conflicts else "CDMETHOD OFF")
    bs.sim.op()
    for _ in range(40):
        bs.sim.step()
    begun = time.process_time()
    for _ in range(steps):
        bs.sim.step()
    spent = time.process_time() - begun
    assert bs.traf.ntraf == count, f"{bs.traf.ntraf} of {count} aircraft are left"
    print(f"STEP_US {1e6 * spent / steps:.3f} {bs.sim.simdt}")


main()
