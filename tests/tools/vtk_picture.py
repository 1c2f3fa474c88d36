#!/usr/bin/python3
"""The same scene through VTK: an independent picture of orientation, geometry and optics.

Reads a NIfTI file (made by dcm2niix from the DICOM folder, so that neither the DICOM reading nor the orientation is
ours) and places it by its qform, or an axis-aligned NRRD; ray-casts it on the CPU, or the GPU with --gpu, orthographic,
with Vitrine's camera; without shading, or with --shade with the preset's ambient, diffuse, specular and power and the
light at the eye (give ours `--set shading.light=[0,0,1]` then). VTK has no boundaries, and its light model
is its own: for looking at, not for numbers.
Needs Debian's python3-vtk9 python3-numpy python3-yaml xvfb dcm2niix:

  dcm2niix -z n -f volume -o /tmp/x FOLDER
  xvfb-run -a tests/tools/vtk_picture.py /tmp/x/volume.nii configs/presets/bone-classic.yaml --view 30,20 -o vtk.png

PRESET may also be 3D Slicer's: FILE.xml:NAME is read here, without Vitrine's importer, so that an imported preset can be
held to it (tests/tools/vtk_presets.sh does).

Note that VTK's box ends at the outer sample centres, half a voxel inside Vitrine's: `clip_mm` of half a spacing on every
side makes the boxes equal.
"""
import argparse
import os
import xml.etree.ElementTree
import numpy as np
import vtk
import yaml
from vtk.util.numpy_support import numpy_to_vtk, vtk_to_numpy

ap = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
ap.add_argument("input", help="NIfTI, or NRRD"); ap.add_argument("preset")
ap.add_argument("--shade", action="store_true"); ap.add_argument("--gpu", action="store_true")
ap.add_argument("--zoom", type=float, default=1)
ap.add_argument("--view", default="0,0", help="AZ,EL in degrees")
ap.add_argument("--size", type=int, default=400)
ap.add_argument("--step", type=float, default=0.1, help="sample distance over the smallest spacing")
ap.add_argument("-o", "--out", required=True)
ap.add_argument("--against", help="a PNG of the same scene and size: print the RMS difference in 1/255, as it is and after "
                "the magnification that VTK's CPU mapper applies to its ray-cast image when it draws it (bilinear, about 0.6 %%)")
a = ap.parse_args()

def read_nifti(path):
    reader = vtk.vtkNIFTIImageReader(); reader.SetFileName(path); reader.Update()
    image = reader.GetOutput()
    stored = vtk_to_numpy(image.GetPointData().GetScalars()).astype(np.float32)
    hu = stored * (reader.GetRescaleSlope() or 1.0) + reader.GetRescaleIntercept()
    image.GetPointData().SetScalars(numpy_to_vtk(hu.astype(np.int16), deep=True))
    ras_from_image = vtk.vtkMatrix4x4(); ras_from_image.DeepCopy(reader.GetQFormMatrix() or reader.GetSFormMatrix())
    lps_from_ras = vtk.vtkMatrix4x4(); lps_from_ras.SetElement(0, 0, -1); lps_from_ras.SetElement(1, 1, -1)
    lps = vtk.vtkMatrix4x4(); vtk.vtkMatrix4x4.Multiply4x4(lps_from_ras, ras_from_image, lps)
    return image, lps

def read_nrrd(path):
    """int16, raw, along the axes; a flipped axis is turned round in the data."""
    data = open(path, "rb").read(); head, _, rest = data.partition(b"\n\n")
    fields = dict(line.split(": ", 1) for line in head.decode().splitlines()[1:] if ": " in line and line[0] != "#")
    pairs = dict(line.split(":=", 1) for line in head.decode().splitlines()[1:] if ":=" in line)
    assert fields["type"] == "int16" and fields["encoding"] == "raw"
    if "data file" in fields:
        rest = open(os.path.join(os.path.dirname(path), fields["data file"].strip()), "rb").read()
    size = [int(v) for v in fields["sizes"].split()]
    raw = np.frombuffer(rest, "<i2", size[0] * size[1] * size[2]).reshape(size[::-1])
    hu = raw * float(pairs.get("vitrine slope", 1)) + float(pairs.get("vitrine intercept", 0))
    rows = np.array([[float(v) for v in d.strip("()").split(",")] for d in fields["space directions"].split()])
    origin = np.array([float(v) for v in fields["space origin"].strip("()").split(",")])
    for axis in range(3):
        if rows[axis, axis] < 0:
            hu = np.flip(hu, 2 - axis); origin += rows[axis] * (size[axis] - 1); rows[axis] *= -1
    image = vtk.vtkImageData(); image.SetDimensions(*size); image.SetSpacing(*np.diag(rows)); image.SetOrigin(*origin)
    image.GetPointData().SetScalars(numpy_to_vtk(np.ascontiguousarray(hu, np.int16).ravel(), deep=True))
    return image, vtk.vtkMatrix4x4()

image, lps_from_image = (read_nifti if a.input.endswith((".nii", ".nii.gz")) else read_nrrd)(a.input)

def ours(path):
    """Points of colour and of opacity, unit distance, light (None: no shading), MIP or not."""
    whole = yaml.safe_load(open(path)); preset = whole["transfer"]
    assert preset["quantity"] == "opacity" and preset.get("emission", "luminance") == "luminance"
    light = whole.get("shading", {})
    return ([(p["hu"], *p["color"]) for p in preset["points"]], [(p["hu"], p["opacity"]) for p in preset["points"]],
            preset.get("unit_mm", 1.0), [light.get(k, 0) for k in ("ambient", "diffuse", "specular", "power")], False)

def slicers(path, name):
    """The same of a VolumeProperty element: every list is a count and that many numbers."""
    element = next(e for e in xml.etree.ElementTree.parse(path).iter("VolumeProperty") if e.get("name") == name)
    def rows(key, width):
        v = [float(t) for t in element.get(key).split()]
        assert v[0] == len(v) - 1 and v[0] % width == 0
        return [v[i:i + width] for i in range(1, len(v), width)]
    assert all(factor == 1 for _, factor in rows("gradientOpacity", 2)), "its unit is not ours: the mean spacing"
    return (rows("colorTransfer", 4), rows("scalarOpacity", 2), 1.0,
            [float(element.get(k)) for k in ("ambient", "diffuse", "specular", "specularPower")], name.endswith("-MIP"))

foreign = a.preset.rpartition(".xml:")
colours, opacities, unit_mm, light, mip = slicers(foreign[0] + ".xml", foreign[2]) if foreign[1] else ours(a.preset)
colour, opacity = vtk.vtkColorTransferFunction(), vtk.vtkPiecewiseFunction()
colour.AllowDuplicateScalarsOn(); opacity.AllowDuplicateScalarsOn()
for p in colours:
    colour.AddRGBPoint(*p)
for p in opacities:
    opacity.AddPoint(*p)
prop = vtk.vtkVolumeProperty(); prop.SetColor(colour); prop.SetScalarOpacity(opacity)
prop.SetInterpolationTypeToLinear(); prop.SetScalarOpacityUnitDistance(unit_mm); prop.ShadeOff()
if a.shade:
    prop.ShadeOn(); prop.SetAmbient(light[0]); prop.SetDiffuse(light[1]); prop.SetSpecular(light[2])
    prop.SetSpecularPower(light[3])

step = a.step * min(image.GetSpacing())
mapper = vtk.vtkOpenGLGPUVolumeRayCastMapper() if a.gpu else vtk.vtkFixedPointVolumeRayCastMapper()
mapper.SetInputData(image); mapper.SetAutoAdjustSampleDistances(0); mapper.SetSampleDistance(step)
mapper.SetImageSampleDistance(1.0)
if mip:
    mapper.SetBlendModeToMaximumIntensity()
if not a.gpu:
    mapper.SetInteractiveSampleDistance(step)
volume = vtk.vtkVolume(); volume.SetMapper(mapper); volume.SetProperty(prop); volume.SetUserMatrix(lps_from_image)
ren = vtk.vtkRenderer(); ren.AddVolume(volume); ren.SetBackground(0, 0, 0)
ren.RemoveAllLights(); head = vtk.vtkLight(); head.SetLightTypeToHeadlight(); ren.AddLight(head)
win = vtk.vtkRenderWindow(); win.SetOffScreenRendering(1); win.SetMultiSamples(0); win.SetSize(a.size, a.size)
win.AddRenderer(ren)

n, s = image.GetDimensions(), image.GetSpacing()
diagonal = float(np.sqrt(sum((k * d) ** 2 for k, d in zip(n, s))))
middle = [(k - 1) * d / 2 + o for k, d, o in zip(n, s, image.GetOrigin())] + [1.0]
centre = np.array(lps_from_image.MultiplyPoint(middle)[:3])
az, el = (np.radians(float(v)) for v in a.view.split(","))
toward = np.array([np.sin(az) * np.cos(el), -np.cos(az) * np.cos(el), np.sin(el)])
up = np.array([0.0, 0.0, 1.0]) if abs(np.cos(el)) > 1e-9 else np.array([-np.sin(az), np.cos(az), 0]) * np.sign(np.sin(el))
cam = ren.GetActiveCamera(); cam.ParallelProjectionOn(); cam.SetParallelScale(diagonal / 2 / a.zoom)
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
