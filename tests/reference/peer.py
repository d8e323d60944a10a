"""The model of "Geometrico-Static Modelling of a FRE Finger" (the paper) by CasADi and IPOPT: an independent formulation, for the times and the forces of `cargo xtask bench`.

Finger `ladder-80`, circle R40 at Mid, `paper` 170/20, inextensible (equations 2 to 7 of the paper). Unknowns are the angles of all
rigid elements and the positions of their ends, with a closure per element: written with the angles alone the program is a fifth as
large but dense, and takes twice as long. Loops close at every lamella and at the tip; gaps are checked at every element end of the
front beam. IPOPT is started from the last solution with all its multipliers; of the barrier strategies tried, `adaptive` was the
quickest (9 iterations per count instead of 26).

    python peer.py                  prints lines
        peer cold MICROSECONDS                from the undeformed finger to 11 degrees in steps of 1 degree
        peer warm MICROSECONDS                one count of the servo's sensor
        peer force cold|COUNT FX FY           on the object, finger frame, N, after the run to 11 degrees and after each count

Times are the processor's, not the wall clock's, so that a busy machine does not count against it.
"""

import math
import time

import casadi as ca

# Finger and object, mm, N, rad.
YOUNG, WIDTH, BEAM, HINGE, NECK = 49.5, 20.0, 2.0, 0.8, 2.5
TIP, BACK = (0.0, 80.0), (-28.0, 0.0)
HEIGHTS = [9.0 * k for k in range(1, 8)]
AXIS, CENTRE, RADIUS = (-14.0, -20.0), (41.0, 45.0), 40.0
PER_BEAM, PER_HINGE = 170, 20
COUNT = 2.0 * math.pi / 4096.0

COLD_RUNS = 3
LAST_DEGREE = 11
# Warm: closing between these counts, from half the force to the peak's.
FIRST_COUNT, LAST_COUNT = 80, 110


def spread(total, lengths):
    """Elements per span by largest remainder, ties towards the tip."""
    share = [total * length / sum(lengths) for length in lengths]
    counts = [max(1, math.floor(s + 1e-9)) for s in share]
    order = sorted(range(len(share)), key=lambda k: (share[k] - counts[k], k), reverse=True)
    for k in order[: total - sum(counts)]:
        counts[k] += 1
    return counts


class Chain:
    """Rigid elements one after the other: directions at rest, lengths, springs to the one before."""

    def __init__(self):
        self.rest, self.length, self.spring = [], [], []

    def add(self, count, length, direction, thickness):
        inertia = WIDTH * thickness**3 / 12.0
        element = length / count
        self.rest += [direction] * count
        self.length += [element] * count
        self.spring += [YOUNG * inertia / element] * count


def beam(base, spans):
    """A beam from its base to the tip, its spans' ends at these heights."""
    chain, direction = Chain(), math.atan2(TIP[1] - base[1], TIP[0] - base[0])
    slant = math.hypot(TIP[0] - base[0], TIP[1] - base[1]) / (TIP[1] - base[1])
    for count, (low, high) in zip(spans, zip([0.0] + HEIGHTS, HEIGHTS + [TIP[1]])):
        chain.add(count, slant * (high - low), direction, BEAM)
    return chain


class Model:
    """The nonlinear program."""

    def __init__(self):
        spans = spread(PER_BEAM, [b - a for a, b in zip([0.0] + HEIGHTS, HEIGHTS + [TIP[1]])])
        ends = [sum(spans[: k + 1]) for k in range(len(spans))]
        front, back = beam((0.0, 0.0), spans), beam(BACK, spans)
        unknowns, energy, closures = [], 0.0, []

        def angles(name, count):
            symbol = ca.SX.sym(name, count)
            unknowns.append(symbol)
            return ca.vertsplit(symbol)

        theta_front = angles("front", PER_BEAM)
        # The beams join rigidly at the tip: one angle.
        theta_back = angles("back", PER_BEAM - 1) + [theta_front[-1]]

        def bend(chain, before, theta):
            total = 0.0
            for spring, angle in zip(chain.spring, theta):
                total += 0.5 * spring * (angle - before) ** 2
                before = angle
            return total

        def walk(name, start, chain, theta):
            """Ends of the elements."""
            points, here = [], start
            for rest, length, angle in zip(chain.rest, chain.length, theta):
                step = ca.vertcat(length * ca.cos(rest + angle), length * ca.sin(rest + angle))
                there = ca.SX.sym(name, 2)
                unknowns.append(there)
                closures.append(there - here - step)
                here = there
                points.append(here)
            return points

        energy += bend(front, 0.0, theta_front) + bend(back, 0.0, theta_back)
        points_front = walk("pf", ca.SX([0.0, 0.0]), front, theta_front)
        points_back = walk("pb", ca.SX(list(BACK)), back, theta_back)
        for k, height in enumerate(HEIGHTS):
            across = -BACK[0] * (1.0 - height / TIP[1])
            neck = Chain()
            neck.add(PER_HINGE, NECK, math.pi, HINGE)
            theta_first = angles(f"f{k}", PER_HINGE)
            lamella = theta_first[-1]
            energy += bend(neck, theta_front[ends[k] - 1], theta_first)
            # The back hinge's last element is rigid with the back beam.
            theta_second = angles(f"b{k}", PER_HINGE - 1) + [theta_back[ends[k] - 1]]
            energy += bend(neck, lamella, theta_second)
            here = walk(f"hf{k}", points_front[ends[k] - 1], neck, theta_first)[-1]
            bar = across - 2.0 * NECK
            here = here + ca.vertcat(-bar * ca.cos(lamella), -bar * ca.sin(lamella))
            here = walk(f"hb{k}", here, neck, theta_second)[-1]
            closures.append(here - points_back[ends[k] - 1])
        closures.append(points_front[-1] - points_back[-1])

        centre = ca.SX.sym("centre", 2)
        touch = RADIUS + 0.5 * BEAM
        gaps = [ca.sqrt(ca.sumsqr(point - centre)) - touch for point in points_front]
        x, closures, gaps = ca.vertcat(*unknowns), ca.vertcat(*closures), ca.vertcat(*gaps)
        options = {
            "print_time": False,
            "ipopt.print_level": 0,
            "ipopt.sb": "yes",
            "ipopt.tol": 1e-9,
            "ipopt.constr_viol_tol": 1e-9,
            "ipopt.compl_inf_tol": 1e-9,
            "ipopt.dual_inf_tol": 1e-6,
            "ipopt.acceptable_tol": 1e-9,
            "ipopt.warm_start_init_point": "yes",
            "ipopt.mu_strategy": "adaptive",
            "ipopt.warm_start_bound_push": 1e-7,
            "ipopt.warm_start_slack_bound_push": 1e-7,
            "ipopt.warm_start_mult_bound_push": 1e-7,
            "ipopt.warm_start_bound_frac": 1e-7,
            "ipopt.warm_start_slack_bound_frac": 1e-7,
        }
        program = {"x": x, "p": centre, "f": energy, "g": ca.vertcat(closures, gaps)}
        self.solver = ca.nlpsol("finger", "ipopt", program, options)
        self.lower = [0.0] * closures.numel() + [0.0] * gaps.numel()
        self.upper = [0.0] * closures.numel() + [math.inf] * gaps.numel()
        self.closures = closures.numel()
        self.gaps = gaps.numel()
        self.points = ca.Function("points", [x], [ca.horzcat(*points_front)])
        self.rest = self.at_rest(unknowns)
        self.reset()

    def at_rest(self, unknowns):
        """All unknowns of the undeformed finger: angles zero, positions where the elements end."""
        values, ends_of = [], {}
        spans = spread(PER_BEAM, [b - a for a, b in zip([0.0] + HEIGHTS, HEIGHTS + [TIP[1]])])
        ends = [sum(spans[: k + 1]) for k in range(len(spans))]

        def walk(name, start, chain):
            points, here = [], start
            for rest, length in zip(chain.rest, chain.length):
                here = (here[0] + length * math.cos(rest), here[1] + length * math.sin(rest))
                points.append(here)
            ends_of[name] = points
            return points

        points = walk("pf", (0.0, 0.0), beam((0.0, 0.0), spans))
        walk("pb", BACK, beam(BACK, spans))
        for k, height in enumerate(HEIGHTS):
            neck = Chain()
            neck.add(PER_HINGE, NECK, math.pi, HINGE)
            here = walk(f"hf{k}", points[ends[k] - 1], neck)[-1]
            bar = -BACK[0] * (1.0 - height / TIP[1]) - 2.0 * NECK
            walk(f"hb{k}", (here[0] - bar, here[1]), neck)
        used = {name: iter(points) for name, points in ends_of.items()}
        for symbol in unknowns:
            name = symbol[0].name().rsplit("_", 1)[0]
            values += list(next(used[name])) if name in used else [0.0] * symbol.numel()
        return values

    def reset(self):
        """Back to the undeformed finger."""
        self.x, self.lam_x, self.lam_g = self.rest, 0.0, 0.0

    def solve(self, angle):
        """From the last solution to this motor angle; force on the object (finger frame) and energy."""
        c, s = math.cos(angle), math.sin(angle)
        arm = (CENTRE[0] - AXIS[0], CENTRE[1] - AXIS[1])
        centre = (AXIS[0] + c * arm[0] - s * arm[1], AXIS[1] + s * arm[0] + c * arm[1])
        found = self.solver(
            x0=self.x, lam_x0=self.lam_x, lam_g0=self.lam_g, p=centre, lbg=self.lower, ubg=self.upper, lbx=-ca.inf, ubx=ca.inf
        )
        if not self.solver.stats()["success"]:
            raise SystemExit(f"IPOPT at {math.degrees(angle):.3f} degrees: {self.solver.stats()['return_status']}")
        self.x, self.lam_x, self.lam_g = found["x"], found["lam_x"], found["lam_g"]
        self.centre, self.energy = centre, float(found["f"])

    def force(self):
        """Force on the object, finger frame: the multipliers along the normals."""
        points, multipliers = self.points(self.x), self.lam_g[self.closures :]
        fx = fy = 0.0
        for j in range(self.gaps):
            dx, dy = float(points[0, j]) - self.centre[0], float(points[1, j]) - self.centre[1]
            distance = math.hypot(dx, dy)
            # CasADi's multiplier of an active lower bound is negative.
            fx += float(multipliers[j]) * dx / distance
            fy += float(multipliers[j]) * dy / distance
        return fx, fy


def main():
    model = Model()
    for _ in range(COLD_RUNS):
        model.reset()
        clock = time.process_time()
        for degree in range(1, LAST_DEGREE + 1):
            model.solve(math.radians(degree))
        print(f"peer cold {1e6 * (time.process_time() - clock):.1f}", flush=True)
    print("peer force cold %r %r" % model.force(), flush=True)
    model.reset()
    for degree in range(1, math.floor(math.degrees(FIRST_COUNT * COUNT)) + 1):
        model.solve(math.radians(degree))
    model.solve(FIRST_COUNT * COUNT)
    for count in range(FIRST_COUNT + 1, LAST_COUNT + 1):
        clock = time.process_time()
        model.solve(count * COUNT)
        print(f"peer warm {1e6 * (time.process_time() - clock):.1f}", flush=True)
        print("peer force %d %r %r" % (count, *model.force()), flush=True)


if __name__ == "__main__":
    main()
