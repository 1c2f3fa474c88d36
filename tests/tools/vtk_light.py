#!/usr/bin/python3
"""Lit pictures of Vitrine beside VTK's GPU and CPU ray casters: to look at, and rings and noise as numbers.

Same volume, transfer function, ambient, diffuse, specular, power, view and size, light at the eye, a sample a voxel. Left to
right: Vitrine, its reference, VTK's GPU caster, VTK's CPU caster; a row per scene: cranium and chest, bone and skin or soft
tissue. The light models differ (README), so pictures are not subtracted from each other. Numbers, in 1/255 of grey, where the
reference is opaque:

  steps  how far a picture is from the same program's with many samples a voxel (ours: the lit reference): RMS of what is
         finer than about six pixels, which is what rings and terraces are
  fine   RMS of the same band of the picture itself, over its mean grey: steps, noise, and what is there

Needs Debian's python3-vtk9 python3-numpy python3-yaml xvfb xauth imagemagick:

  tests/tools/vtk_light.py --vitrine build/release/vitrine --cranium CRANIUM.nhdr --chest FOLDER -o OUT
"""
import argparse, os, subprocess, sys
import numpy as np
import yaml

HERE = os.path.dirname(os.path.abspath(__file__))
ap = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
ap.add_argument("--vitrine", default="build/release/vitrine"); ap.add_argument("--cranium")
ap.add_argument("--chest"); ap.add_argument("--size", type=int, default=400); ap.add_argument("-o", "--out", required=True)
ap.add_argument("--fine", type=float, default=0.125, help="VTK's truth: sample distance over the smallest spacing")
a = ap.parse_args()
os.makedirs(a.out, exist_ok=True)
path = lambda name: os.path.join(a.out, name)
run = lambda *command: subprocess.run(command, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


def ours(scene, name, *more):
    run(a.vitrine, "snapshot", scene["input"], "-q", "--preset", scene["preset"], "--view", scene["view"], "--zoom", scene["zoom"],
        "--size", f"{a.size}x{a.size}", "--set", "shading.light=[0,0,1]", *more, "-o", path(name))


def vtk(scene, name, step, *more):
    run("xvfb-run", "-a", "-s", "-screen 0 1920x1200x24", sys.executable, os.path.join(HERE, "vtk_picture.py"), scene["input"],
        scene["preset"], "--view", scene["view"], "--zoom", scene["zoom"], "--size", str(a.size), "--shade", "--step", str(step),
        "-o", path(name), *more)


def grey(name):
    raw = subprocess.run(["convert", path(name), "-depth", "8", "rgb:-"], check=True, stdout=subprocess.PIPE).stdout
    return np.frombuffer(raw, "u1").reshape(a.size, a.size, 3).astype(float) @ [0.299, 0.587, 0.114]


def blur(picture, sigma=2.0):
    at = np.arange(-8, 9); kernel = np.exp(-at ** 2 / (2 * sigma ** 2)); kernel /= kernel.sum()
    for axis in range(2):
        picture = np.apply_along_axis(lambda row: np.convolve(np.pad(row, 8, mode="edge"), kernel, "valid"), axis, picture)
    return picture


def band(picture):
    return picture - blur(picture)


def inside(scene):
    """Opaque in the reference, eight pixels from anything that is not."""
    ours(scene, "mask.nrrd", "--set", "shading.model=none")
    data = open(path("mask.nrrd"), "rb").read()
    alpha = np.frombuffer(data[-16 * a.size ** 2:], "<f4").reshape(a.size, a.size, 4)[..., 3]
    return blur((alpha < 0.98).astype(float), 3) < 0.02


def scene_numbers(scene):
    name = scene["name"]
    mask = inside(scene)
    ours(scene, name + "-ours.png"); ours(scene, name + "-reference.png", "--path", "reference")
    for kind, option in (("gpu", ["--gpu"]), ("cpu", [])):
        vtk(scene, f"{name}-{kind}.png", 1, *option)
        vtk(scene, f"{name}-{kind}-fine.png", a.fine, *option)
    rms = lambda picture: float(np.sqrt((picture[mask] ** 2).mean()))
    for kind, truth in (("ours", "reference"), ("gpu", "gpu-fine"), ("cpu", "cpu-fine"), ("reference", None)):
        picture = grey(f"{name}-{kind}.png")
        steps = "" if truth is None else f"{rms(band(picture - grey(f'{name}-{truth}.png'))):.2f}"
        print(f"| {name} | {kind} | {steps} | {rms(band(picture)) / picture[mask].mean() * 100:.2f} % | {picture[mask].mean():.0f} |", flush=True)


def preset(name):
    """Without what VTK has not, or measures otherwise: boundaries, and opacity by gradient."""
    whole = yaml.safe_load(open(os.path.join(HERE, "../../configs/presets", name + ".yaml")))
    with open(path(name + ".yaml"), "w") as out:
        yaml.safe_dump({k: v for k, v in whole.items() if k not in ("boundaries", "gradient_opacity")}, out)
    return path(name + ".yaml")


scenes = [dict(name=f"cranium-{p}", input=a.cranium, preset=preset(p), view="30,12", zoom="1.6") for p in ("bone", "skin") if a.cranium]
if a.chest:
    run(a.vitrine, "convert", a.chest, "-q", "-o", path("chest.nhdr"))
    scenes += [dict(name=f"chest-{p}", input=path("chest.nhdr"), preset=preset(p), view="20,30", zoom="1.6") for p in ("bone", "soft-tissue")]
print("| scene | picture | steps: RMS /255 | fine: RMS over mean | mean grey |\n|---|---|---:|---:|---:|")
tiles = []
for scene in scenes:
    scene_numbers(scene)
    tiles += [path(f"{scene['name']}-{kind}.png") for kind in ("ours", "reference", "gpu", "cpu")]
run("montage", *tiles, "-tile", "4x", "-geometry", "+2+2", "-background", "#888", path("vtk-light.png"))
