# SPDX-License-Identifier: LGPL-3.0-or-later
"""FE and FE x DEM: singular, near-incompressible, softening and distorted problems; steps far too large; the paper's
own model."""
import math
import os

from bench import Run, case

CELL = "studies/one_cell.toml"


def bvp(tmp, scene, *sets, **more):
    return Run(tmp, scene, *sets, program="grus-bvp", **more)


def solid(poisson, cells="[2, 2, 2]", top="[0, 0, -1e-4]", sides=True, element="", mesh=""):
    text = mesh or (f"[mesh]\nbox = {{ size = [0.1, 0.1, 0.1], cells = {cells}, cell = \"hexahedron\" }}\n"
                    "dimension = \"3d\"\n")
    text += (f"{element}[[region]]\nwhere = \"z>-1\"\nmaterial = \"elastic\"\nyoungs_modulus = 1e7\n"
             f"poissons_ratio = {poisson!r}\ndensity = 2000.0\n")
    text += (f"[[boundary]]\nwhere = \"z=max\"\ndisplacement = {top}\n[[boundary]]\nwhere = \"z=min\"\n"
             "displacement = [0, 0, 0]\n")
    if sides:
        for where, fixed in (("x=min", '[0, "free", "free"]'), ("x=max", '[0, "free", "free"]'),
                             ("y=min", '["free", 0, "free"]'), ("y=max", '["free", 0, "free"]')):
            text += f"[[boundary]]\nwhere = \"{where}\"\ndisplacement = {fixed}\n"
    return text + "[solve]\nkind = \"quasi-static\"\nincrements = 2\n"


@case("elastic oedometer, Poisson's ratio 0, 0.3, 0.49, 0.499, 0.4999",
      "modulus E (1-v) / ((1+v)(1-2v)), to second order in the strain of 1e-3")
def incompressible(tmp):
    found, good = [], True
    for v in (0.0, 0.3, 0.49, 0.499, 0.4999):
        r = bvp(tmp, solid(v))
        exact = 1e7 * (1 - v) / ((1 + v) * (1 - 2 * v)) * 1e-3 * 0.01
        off = abs(r.last("reaction_zmax_z_N") / -exact - 1) if r.exit == 0 else math.inf
        found.append(f"{v}: {off:.0e}")
        good = good and off < 3e-3
    return ", ".join(found), good


@case("a cell pulled until every contact opens: stress 0, tangent singular",
      "the macro problem goes on to its end; reaction < 1e-6 of the start's (1 MN)")
def opened(tmp):
    # 1 N is 2e-6 of the floor's stress: at 1e-3 a single grain that just touches, or none, is rest.
    r = bvp(tmp, CELL, "boundary.0.displacement=[0,0,'20 mm']", "rve.stress_change=1e-6", "rve.unbalanced_force=1e-6")
    force = r.last("reaction_zmax_z_N") if r.exit in (0, 3) else math.nan
    return f"exit {r.exit}, reaction {force:g} N {r.error[-60:]}", r.exit == 0 and abs(force) < 1


@case("a block of 64 cells pulled apart: free nodes that nothing holds",
      "the macro problem goes on to its end; the force falls below 1e-3 of the start's")
def opened_block(tmp):
    r = bvp(tmp, "oedometer_block.toml", "rve.variants=1", "boundary.0.displacement=['free','free',4e-4]",
            "solve.increments=4", "output.frames=0", "probe=", timeout=300)
    force = [abs(v) for v in r.columns["reaction_zmax_z_N"]]
    return (f"exit {r.exit}, force {force[-1]:.2g} N {r.error.split(': ', 1)[-1][:80]}", r.exit == 0 and r.finite
            and force[-1] < 1e-3 * 400)


@case("macro increment a hundred times too large: 20 % in one",
      "cut back or carried through; the force within 15 % of that in 40 increments")
def huge_increment(tmp):
    one = bvp(tmp, CELL, "solve.increments=1", "boundary.0.displacement=[0,0,'-0.1 m']", "rve.strain_per_step=1e-5")
    many = bvp(tmp, CELL, "solve.increments=40", "boundary.0.displacement=[0,0,'-0.1 m']", "rve.strain_per_step=1e-5")
    off = one.last("reaction_zmax_z_N") / many.last("reaction_zmax_z_N") - 1
    return (f"{100 * off:+.1f} %, {one.summary['counts']['cutbacks']} cutbacks", one.exit == many.exit == 0
            and abs(off) < 0.15)


@case("softening, breaking cells with a quasi-Newton tangent that goes wrong (correction 70 x the increment)",
      "corrections are cut to the increment; ends, force within 10 % of the network tangent's")
def wild_tangent(tmp):
    common = ("mesh.box.cells=[1,1,2]", "rve.variants=2", "boundary.0.displacement=['free','free',-5e-4]",
              "solve.increments=5", "output.frames=0", "probe=")
    wild, plain = (bvp(tmp, "oedometer_block.toml", *common, f"rve.tangent={t}", *more)
                   for t, more in (("quasi-newton", ("rve.adaptivity.share=1e-3", "rve.adaptivity.error=0.02",
                                                     "rve.adaptivity.elastic=0.02")), ("network", ())))
    if wild.exit or plain.exit:
        return wild.error + plain.error, False
    off = wild.last("reaction_zmax_z_N") / plain.last("reaction_zmax_z_N") - 1
    return (
        f"{100 * off:+.1f} %, {wild.summary['counts']['cutbacks']} cutbacks, "
        f"{wild.summary['counts']['material_sweeps']} sweeps",
        abs(off) < 0.1)


@case("an element whose nodes are listed the other way round; a flat one; a node given twice",
      "taken, with the forces of the other order to 1e-9; refused in one line that names the element")
def inverted(tmp):
    found, good = [], True
    nodes = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
    force = {}
    for name, points in (("upright", nodes), ("inverted", [nodes[0], nodes[2], nodes[1], nodes[3]]),
                         ("flat", [*nodes[:3], (1, 1, 0)]), ("collapsed", [*nodes[:3], nodes[2]])):
        path = os.path.join(tmp, name + ".msh")
        with open(path, "w") as f:
            f.write("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n4\n" +
                    "".join(f"{i + 1} {x} {y} {z}\n" for i, (x, y, z) in enumerate(points)) +
                    "$EndNodes\n$Elements\n1\n1 4 2 1 1 1 2 3 4\n$EndElements\n")
        r = bvp(tmp, solid(0.3, sides=False, mesh=f"[mesh]\nfile = \"{path}\"\ndimension = \"3d\"\n"))
        found.append(f"{name}: exit {r.exit} {r.error.split('.msh: ')[-1][:60]}")
        if name in ("upright", "inverted"):
            force[name] = r.last("reaction_zmax_z_N") if r.exit == 0 else math.nan
        else:
            good = good and r.refused("element 1")
    return "; ".join(found), good and abs(force["inverted"] / force["upright"] - 1) < 1e-9


@case("a lid pushed through the bottom: elements turn inside out",
      "cut back, then stopped with exit 3; results up to there kept")
def inside_out(tmp):
    r = bvp(tmp, solid(0.3, top="[0, 0, -0.2]", sides=False))
    return f"exit {r.exit}: {r.error.split(': ', 1)[-1][:90]}", r.stopped()


@case("explicit dynamics at 0.9 and 1.5 of its critical step",
      "a load set on at once: energy error < 2 % once the wave has crossed the bar, not growing; found, exit 3")
def explicit(tmp):
    text = solid(0.0, cells="[1, 1, 10]", top='["free", "free", "free"]',
                 sides=False).replace("[solve]\nkind = \"quasi-static\"\nincrements = 2\n", "")
    text = text.replace("[[boundary]]\nwhere = \"z=max\"\ndisplacement = [\"free\", \"free\", \"free\"]\n",
                        "[[boundary]]\nwhere = \"z=max\"\ntraction = [0, 0, -1e3]\nhistory = \"constant\"\n")
    text += "[solve]\nkind = \"explicit-dynamic\"\nduration = 2e-2\nsafety = 0.9\n"
    good, bad = bvp(tmp, text), bvp(tmp, text + f"time_step = {1.5 * 0.01 / math.sqrt(1e7 / 2000)!r}\n")
    errors = [abs(v) for v in good.columns["macro_energy_error"]]
    half = len(errors) // 2
    energy = max(
        errors[half:]) if good.exit == 0 and max(errors[half:]) <= 1.2 * max(errors[half // 2:half]) else math.nan
    return (f"{energy:.0e}; exit {bad.exit}: {bad.error.split(': ', 1)[-1][:60]}", good.exit == 0 and energy < 0.02
            and bad.stopped())


@case("the paper's own time step (Zhang et al. 2015, Table 1: 'blow up') and ours",
      "held, it is found out (exit 3); as a bound only, and with our step, the grain is crushed to the end")
def paper(tmp):
    ours = Run(tmp, "single_grain.toml", "output.frames=0")
    held, bounded = (Run(tmp, "zhang2015/single_grain.toml", "output.frames=0", "loading.strain_rate=1",
                         f"numerics.{key}=5e-7") for key in ("time_step", "max_time_step"))
    return (
        f"held at 5e-7 s ('blow up' in Table 1): exit {held.exit}, {held.error.split(': ', 1)[-1][:60]}; bounded by "
        f"it: exit {bounded.exit}, energy {bounded.energy:.0e}; "
        f"ours: exit {ours.exit}, energy {ours.energy:.0e}", held.stopped() and bounded.exit == 0
        and bounded.energy < 0.05 and ours.exit == 0 and ours.energy < 0.02)


@case("shape transition at once, as in the paper ('unstable'), and over 10 us, as here",
      "at once, it is found out (exit 3); over 10 us the sample is crushed to 15 % with an energy error < 2 %")
def shape_transition(tmp):
    common = ('packing.box=["3.79 mm", "3.79 mm", "3.79 mm"]', "packing.count=", "loading.final_strain=0.15",
              "output.frames=0", "material.sand.fracture.shape_transition.ratio=0.5",
              'material.sand.fracture.smallest_radius="0.1 mm"')
    once, slow = (Run(tmp, "shpb_random.toml", *common, f'material.sand.fracture.shape_transition.time="{t}"')
                  for t in ("1e-9 s", "10 us"))
    return (
        f"at once: exit {once.exit}, {once.error.split(': ', 1)[-1][:50]}; over 10 us: exit {slow.exit}, "
        f"{slow.last('breakages'):.0f} breakages, energy {slow.energy:.1e}",
        once.stopped("energy") and slow.exit == 0 and slow.energy < 0.02 and slow.last("breakages") > 100)
