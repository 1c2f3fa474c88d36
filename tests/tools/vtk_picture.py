#!/usr/bin/python3
"""The same scene through VTK: an independent picture of orientation, geometry and optics.

Reads a NIfTI file (made by dcm2niix from the DICOM folder, so that neither the DICOM reading nor the orientation is
ours), places it by its qform, and ray-casts it on the CPU without shading, orthographic, with Vitrine's camera.
Needs Debian's python3-vtk9 python3-numpy python3-yaml xvfb dcm2niix:

  dcm2niix -z n -f volume -o /tmp/x FOLDER
  xvfb-run -a tests/tools/vtk_picture.py /tmp/x/volume.nii configs/presets/bone-classic.yaml --view 30,20 -o vtk.png

Note that VTK's box ends at the outer sample centres, half a voxel inside Vitrine's: `clip_mm` of half a spacing on every
side makes the boxes equal.
"""
import argparse
import numpy as np
import vtk
import yaml
from vtk.util.numpy_support import numpy_to_vtk, vtk_to_numpy

ap = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
ap.add_argument("nifti"); ap.add_argument("preset")
ap.add_argument("--view", default="0,0", help="AZ,EL in degrees")
ap.add_argument("--size", type=int, default=400)
ap.add_argument("--step", type=float, default=0.1, help="sample distance over the smallest spacing")
ap.add_argument("-o", "--out", required=True)
ap.add_argument("--against", help="a PNG of the same scene and size: print the RMS difference in 1/255, as it is and after "
                "the magnification that VTK's CPU mapper applies to its ray-cast image when it draws it (bilinear, about 0.6 %%)")
a = ap.parse_args()

reader = vtk.vtkNIFTIImageReader(); reader.SetFileName(a.nifti); reader.Update()
image = reader.GetOutput()
slope = reader.GetRescaleSlope() or 1.0
stored = vtk_to_numpy(image.GetPointData().GetScalars()).astype(np.float32)
scalars = numpy_to_vtk((stored * slope + reader.GetRescaleIntercept()).astype(np.int16), deep=True)
image.GetPointData().SetScalars(scalars)
ras_from_image = vtk.vtkMatrix4x4(); ras_from_image.DeepCopy(reader.GetQFormMatrix() or reader.GetSFormMatrix())
lps_from_ras = vtk.vtkMatrix4x4(); lps_from_ras.SetElement(0, 0, -1); lps_from_ras.SetElement(1, 1, -1)
lps_from_image = vtk.vtkMatrix4x4(); vtk.vtkMatrix4x4.Multiply4x4(lps_from_ras, ras_from_image, lps_from_image)

preset = yaml.safe_load(open(a.preset))["transfer"]
assert preset["quantity"] == "opacity" and preset.get("emission", "luminance") == "luminance"
colour, opacity = vtk.vtkColorTransferFunction(), vtk.vtkPiecewiseFunction()
for p in preset["points"]:
    colour.AddRGBPoint(p["hu"], *p["color"]); opacity.AddPoint(p["hu"], p["opacity"])
prop = vtk.vtkVolumeProperty(); prop.SetColor(colour); prop.SetScalarOpacity(opacity)
prop.SetInterpolationTypeToLinear(); prop.SetScalarOpacityUnitDistance(preset.get("unit_mm", 1.0)); prop.ShadeOff()

step = a.step * min(image.GetSpacing())
mapper = vtk.vtkFixedPointVolumeRayCastMapper(); mapper.SetInputData(image)
mapper.SetAutoAdjustSampleDistances(0); mapper.SetSampleDistance(step); mapper.SetInteractiveSampleDistance(step)
mapper.SetImageSampleDistance(1.0)
volume = vtk.vtkVolume(); volume.SetMapper(mapper); volume.SetProperty(prop); volume.SetUserMatrix(lps_from_image)
ren = vtk.vtkRenderer(); ren.AddVolume(volume); ren.SetBackground(0, 0, 0)
win = vtk.vtkRenderWindow(); win.SetOffScreenRendering(1); win.SetMultiSamples(0); win.SetSize(a.size, a.size)
win.AddRenderer(ren)

n, s = image.GetDimensions(), image.GetSpacing()
diagonal = float(np.sqrt(sum((k * d) ** 2 for k, d in zip(n, s))))
middle = [(k - 1) * d / 2 + o for k, d, o in zip(n, s, image.GetOrigin())] + [1.0]
centre = np.array(lps_from_image.MultiplyPoint(middle)[:3])
az, el = (np.radians(float(v)) for v in a.view.split(","))
toward = np.array([np.sin(az) * np.cos(el), -np.cos(az) * np.cos(el), np.sin(el)])
up = np.array([0.0, 0.0, 1.0]) if abs(np.cos(el)) > 1e-9 else np.array([-np.sin(az), np.cos(az), 0]) * np.sign(np.sin(el))
cam = ren.GetActiveCamera(); cam.ParallelProjectionOn(); cam.SetParallelScale(diagonal / 2)
cam.SetFocalPoint(*centre); cam.SetPosition(*(centre + 2 * diagonal * toward)); cam.SetViewUp(*up)
ren.ResetCameraClippingRange(); win.Render()
grab = vtk.vtkWindowToImageFilter(); grab.SetInput(win); grab.ReadFrontBufferOff()
png = vtk.vtkPNGWriter(); png.SetFileName(a.out); png.SetInputConnection(grab.GetOutputPort()); png.Write()

def pixels(path):
    r = vtk.vtkPNGReader(); r.SetFileName(path); r.Update(); d = r.GetOutput()
    n = d.GetDimensions()
    return vtk_to_numpy(d.GetPointData().GetScalars()).reshape(n[1], n[0], -1)[..., :3].astype(float)

def magnified(picture, factor):
    """Bilinear, about the centre: what a texture drawn `factor` times too large shows."""
    n = picture.shape[0]
    at = np.clip((np.arange(n) + 0.5 - n / 2) / factor + n / 2 - 0.5, 0, n - 1.001)
    i, f = at.astype(int), at - at.astype(int)
    rows = picture[i] * (1 - f)[:, None, None] + picture[i + 1] * f[:, None, None]
    return rows[:, i] * (1 - f)[None, :, None] + rows[:, i + 1] * f[None, :, None]

if a.against:
    theirs, ours = pixels(a.out), pixels(a.against)
    rms = lambda x: float(np.sqrt(((x - theirs) ** 2).mean()))
    best = min(np.arange(1.0, 1.0201, 0.0005), key=lambda k: rms(magnified(ours, k)))
    print(f"RMS {rms(ours):.2f}/255; ours magnified {best:.4f}: {rms(magnified(ours, best)):.2f}/255")
