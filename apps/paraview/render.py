# SPDX-License-Identifier: LGPL-3.0-or-later
# A picture of a sample by ParaView: pvpython render.py RESULTS [PICTURE.png] (without a screen: xvfb-run pvpython ...).
# Grains by mean pressure, half of them cut away;
# force chains as tubes where output.contacts = true. The last frame; open the .series files in ParaView for all.
import glob
import os
import sys

from paraview.simple import *  # noqa: F403

results = sys.argv[1]
last = lambda what: sorted(glob.glob(os.path.join(results, what, what + "_*.hdf")))[-1:]
view = CreateView("RenderView")
view.Background, view.UseColorPaletteForBackground = [1, 1, 1], 0
grains = OpenDataFile(last("grains")[0])
grains.UpdatePipeline()
low, high = (grains.GetDataInformation().GetBounds()[k::2] for k in (0, 1))
cut = Clip(Input=grains, ClipType="Plane")
cut.ClipType.Origin, cut.ClipType.Normal = [(a + b) / 2 for a, b in zip(low, high)], [0, 1, 0]
shown = Show(cut, view)
ColorBy(shown, ("CELLS", "mean_pressure_Pa"))
shown.SetScalarBarVisibility(view, True)
bar = GetScalarBar(GetColorTransferFunction("mean_pressure_Pa"), view)
bar.TitleColor = bar.LabelColor = [0, 0, 0]
view.OrientationAxesVisibility = 0
for path in last("contacts"):
    shown.Opacity = 0.3
    forces = CellDatatoPointData(Input=ExtractSurface(Input=OpenDataFile(path)))
    forces.UpdatePipeline()
    size = max(b - a for a, b in zip(low, high))
    chains = Tube(Input=forces, Scalars=["POINTS", "normal_force_N"], VaryRadius="By Scalar", Radius=1e-3 * size,
                  RadiusFactor=30)
    Show(chains, view).DiffuseColor = [0.6, 0.05, 0.05]
view.CameraPosition, view.CameraViewUp = [h + (h - l) * f for l, h, f in zip(low, high, (1.2, -3.2, 1.1))], [0, 0, 1]
view.CameraFocalPoint = [(a + b) / 2 for a, b in zip(low, high)]
ResetCamera(view)
SaveScreenshot(sys.argv[2] if len(sys.argv) > 2 else os.path.join(results, "sample.png"), view,
               ImageResolution=[1200, 900])
