#!/usr/bin/python3
"""VTK's volume mappers for peers.py: vtk_bench.py cpu|gpu RAW NX NY NZ DX DY DZ SIZE FRAMES TABLE SHADE AZIMUTH OUT.ppm

Voxels are little-endian int16 HU whose axes run L, P, S. Geometry is Vitrine's: azimuth 0 looks from anterior (-y), up +z,
the diagonal of the n*spacing box spans the image; samples are one smallest spacing apart. VTK's own box ends at the outer
sample centres, half a voxel inside Vitrine's. After one frame, FRAMES frames of a full turn from AZIMUTH on are timed, and
one more with a transfer function that has moved by a HU; with 0 only the picture at AZIMUTH is made. Needs an X server.
"""
import json, sys, time
import numpy as np
import vtk
from vtk.util.numpy_support import numpy_to_vtk

mode, raw = sys.argv[1:3]
n, spacing = [int(x) for x in sys.argv[3:6]], [float(x) for x in sys.argv[6:9]]
size, frames, table, shade, azimuth, out = int(sys.argv[9]), int(sys.argv[10]), sys.argv[11], int(sys.argv[12]), float(sys.argv[13]), sys.argv[14]

start = time.perf_counter()
image = vtk.vtkImageData(); image.SetDimensions(*n); image.SetSpacing(*spacing)
image.SetOrigin(*[-(k - 1) * d / 2 for k, d in zip(n, spacing)])
voxels = np.fromfile(raw, "<i2")
image.GetPointData().SetScalars(numpy_to_vtk(voxels, deep=False))
colour, opacity = vtk.vtkColorTransferFunction(), vtk.vtkPiecewiseFunction()


def set_transfer(shift):
    colour.RemoveAllPoints(); opacity.RemoveAllPoints()
    for hu, r, g, b, o in np.loadtxt(table):
        colour.AddRGBPoint(hu + shift, r, g, b); opacity.AddPoint(hu + shift, o)


set_transfer(0)
prop = vtk.vtkVolumeProperty(); prop.SetColor(colour); prop.SetScalarOpacity(opacity); prop.SetInterpolationTypeToLinear()
prop.SetScalarOpacityUnitDistance(1.0)
prop.SetShade(shade); prop.SetAmbient(.1); prop.SetDiffuse(.9); prop.SetSpecular(.2); prop.SetSpecularPower(10)
step = min(spacing)
if mode == "gpu":
    mapper = vtk.vtkGPUVolumeRayCastMapper(); mapper.SetUseJittering(0)
else:
    mapper = vtk.vtkFixedPointVolumeRayCastMapper(); mapper.SetImageSampleDistance(1.0); mapper.SetInteractiveSampleDistance(step)
mapper.SetAutoAdjustSampleDistances(0); mapper.SetSampleDistance(step); mapper.SetInputData(image)
volume = vtk.vtkVolume(); volume.SetMapper(mapper); volume.SetProperty(prop)
ren = vtk.vtkRenderer(); ren.AddVolume(volume); ren.SetBackground(0, 0, 0)
win = vtk.vtkRenderWindow(); win.SetOffScreenRendering(1); win.SetMultiSamples(0); win.SetSize(size, size); win.AddRenderer(ren)
diagonal = float(np.sqrt(sum((k * d) ** 2 for k, d in zip(n, spacing))))
cam = ren.GetActiveCamera(); cam.ParallelProjectionOn(); cam.SetParallelScale(diagonal / 2); cam.SetFocalPoint(0, 0, 0); cam.SetViewUp(0, 0, 1)


def draw(degrees):
    """Milliseconds by the wall, and of the processor, all threads."""
    a, r = np.radians(degrees), 2 * diagonal
    cam.SetPosition(r * np.sin(a), -r * np.cos(a), 0); ren.ResetCameraClippingRange()
    start, cpu = time.perf_counter(), time.process_time()
    win.Render()
    if mode == "gpu":
        win.WaitForCompletion()
    return 1e3 * (time.perf_counter() - start), 1e3 * (time.process_time() - cpu)


draw(azimuth)
ready = 1e3 * (time.perf_counter() - start)
if frames == 0:
    grab = vtk.vtkWindowToImageFilter(); grab.SetInput(win); grab.ReadFrontBufferOff()
    ppm = vtk.vtkPNMWriter(); ppm.SetFileName(out); ppm.SetInputConnection(grab.GetOutputPort()); ppm.Write()
    sys.exit()
ms = [draw(azimuth + 360.0 * i / frames) for i in range(frames)]
set_transfer(1)
changed = draw(azimuth + 180.0 / frames)
memory = [int(line.split()[1]) for line in open("/proc/self/status") if line.startswith("VmHWM")][0] / 1e3
print(json.dumps(dict(program="VTK " + vtk.vtkVersion().GetVTKVersion(), load_ms=max(0, ready - float(np.median([m[0] for m in ms]))),
                      frame_ms=[m[0] for m in ms], frame_cpu_ms=[m[1] for m in ms], changed_ms=changed[0], memory_mb=memory)))
