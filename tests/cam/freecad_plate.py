"""Run by freecadcmd (see make.py): a plate with contour, pocket and holes, and its programs from
FreeCAD's own posts."""

import importlib
import os

import FreeCAD
import Part
import PathScripts.PathDrilling as PathDrilling
import PathScripts.PathHelix as PathHelix
import PathScripts.PathJob as PathJob
import PathScripts.PathPocketShape as PathPocketShape
import PathScripts.PathProfile as PathProfile

HOLES = ((6, 6), (34, 6), (34, 24), (6, 24))

print("FREECAD", ".".join(FreeCAD.Version()[:3]))
document = FreeCAD.newDocument("Plate")
plate = Part.makeBox(40, 30, 8)
upright = [edge for edge in plate.Edges if abs(edge.tangentAt(edge.FirstParameter).z) > 0.9]
plate = plate.makeFillet(6, upright).cut(Part.makeCylinder(8, 4, FreeCAD.Vector(20, 15, 4)))
for x, y in HOLES:
    plate = plate.cut(Part.makeCylinder(1.5, 8, FreeCAD.Vector(x, y, 0)))
model = document.addObject("Part::Feature", "Plate")
model.Shape = plate
document.recompute()

job = PathJob.Create("Job", [model], None)
controller = job.Tools.Group[0]
controller.HorizFeed, controller.VertFeed = "600 mm/min", "200 mm/min"
controller.SpindleSpeed = 8000
controller.Tool.Diameter = "3 mm"
base = job.Model.Group[0]


def faces(want):
    return [f"Face{k}" for k, face in enumerate(base.Shape.Faces, 1) if want(face)]


bottom = faces(lambda f: f.BoundBox.ZLength < 1e-6 and abs(f.BoundBox.ZMin - 4) < 1e-6)
walls = faces(lambda f: abs(f.BoundBox.XLength - 3) < 1e-6 and abs(f.BoundBox.YLength - 3) < 1e-6)

profile = PathProfile.Create("Profile")
profile.UseComp, profile.StepDown = True, "5 mm"
pocket = PathPocketShape.Create("Pocket")
pocket.Base = [(base, bottom)]
pocket.StepDown, pocket.StepOver, pocket.OffsetPattern = "3 mm", 60, "Offset"
helix = PathHelix.Create("Helix")
helix.Base = [(base, walls[:1])]
helix.StepDown = "4 mm"
drilling = PathDrilling.Create("Drilling")
drilling.Base = [(base, walls)]
for operation in (profile, pocket, helix, drilling):
    operation.ToolController = controller
document.recompute()
for operation in (profile, pocket, helix, drilling):
    print(operation.Label, len(operation.Path.Commands))

chain = [controller, profile, pocket, helix, drilling]
for line in os.environ["CAM_POSTS"].splitlines():
    name, post, *arguments = line.split()
    path = os.path.join(os.environ["CAM_OUT"], f"{name}.nc")
    written = importlib.import_module(f"PathScripts.post.{post}_post")
    importlib.reload(written).export(chain, path, " ".join(["--no-show-editor", *arguments]))
