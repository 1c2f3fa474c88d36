#!/usr/bin/python3
"""dicom_check.py DATA - every file of the awkward folders, both dcm_qa_ct studies and the chest of ../shared/data: what
Vitrine does with it, held to what pydicom reads (with GDCM for compressed pixels). TAP; the rows of the
README's table are printed as comments. Needs python3-pydicom, python3-numpy, python3-gdcm, libgdcm-tools.
VITRINE names the binary."""
import json
import os
import subprocess
import sys
import tempfile
import warnings

import numpy as np
import pydicom

from tap import finish, say

warnings.simplefilter("ignore")
VITRINE = os.environ.get("VITRINE", "build/release/vitrine")
AIR = -1024


def run(*arguments):
    return subprocess.run(arguments, stdout=subprocess.PIPE, stderr=subprocess.PIPE, timeout=120)


def read_nrrd(path):
    head, body = open(path, "rb").read().split(b"\n\n", 1)
    fields = dict(line.replace(":=", ": ").split(": ", 1) for line in head.decode().split("\n")[1:] if ": " in line or ":=" in line)
    sizes = [int(n) for n in fields["sizes"].split()]
    samples = np.frombuffer(body, {"int16": "<i2", "uint16": "<u2"}[fields["type"]]).reshape(sizes[::-1])
    values = samples * float(fields.get("vitrine slope", 1)) + float(fields.get("vitrine intercept", 0))
    directions = np.array([[float(x) for x in v.strip("()").split(",")] for v in fields["space directions"].split()])
    origin = np.array([float(x) for x in fields["space origin"].strip("()").split(",")])
    return values, directions, origin


def vitrine_values(folder, source, *more):
    out = os.path.join(folder, "v.nrrd")
    done = run(VITRINE, "convert", source, "-o", out, *more)
    return (read_nrrd(out) if done.returncode == 0 else None), done


def oracle_values(path):
    """Frames as values of their rescale, and where padding is; None when pydicom cannot."""
    data = pydicom.dcmread(path, force=True)
    if data.get("SamplesPerPixel", 1) != 1 or not data.get("Rows"):
        return None
    if data.file_meta.get("TransferSyntaxUID", pydicom.uid.ImplicitVRLittleEndian).is_compressed:
        try:
            data.convert_pixel_data("gdcm")
        except Exception:
            data.convert_pixel_data()
    stored = data.pixel_array.astype(float)
    slope, intercept = float(data.get("RescaleSlope", 1)), float(data.get("RescaleIntercept", 0))
    groups = data.get("PerFrameFunctionalGroupsSequence")
    if groups and "PixelValueTransformationSequence" in groups[0]:
        value = groups[0].PixelValueTransformationSequence[0]
        slope, intercept = float(value.RescaleSlope), float(value.RescaleIntercept)
    elif groups and "PixelValueTransformationSequence" in data.SharedFunctionalGroupsSequence[0]:
        value = data.SharedFunctionalGroupsSequence[0].PixelValueTransformationSequence[0]
        slope, intercept = float(value.RescaleSlope), float(value.RescaleIntercept)
    if data.get("PhotometricInterpretation") == "MONOCHROME1" and data.get("Modality") != "CT":
        stored = stored.min() + stored.max() - stored
    padded = np.zeros(stored.shape, bool)
    if "PixelPaddingValue" in data:
        value = data.PixelPaddingValue
        value = value if isinstance(value, int) else int.from_bytes(bytes(value)[:2], "little")
        if data.PixelRepresentation == 1 and value > 32767:
            value -= 65536
        padded = stored == value
    return stored * slope + intercept, padded


def compare(ours, oracle):
    values, padded = oracle
    values = values.reshape(-1, *values.shape[-2:])
    padded = padded.reshape(values.shape)
    if values.shape != ours.shape:
        return f"{ours.shape} voxels for {values.shape}"
    best = min((np.abs(np.where(padded, ours, a) - ours).max() for a in (values, values[::-1])))
    return float(best)


def check_file(folder, path, name):
    read, done = vitrine_values(folder, path)
    lines = done.stderr.decode(errors="replace").strip().split("\n")
    if done.returncode not in (0, 3):
        say(False, f"{name}: exit {done.returncode}")
        return
    try:
        oracle = oracle_values(path)
    except Exception as problem:
        oracle = None
        print(f"#   pydicom: {str(problem)[:100]}")
    if not read:
        reason = lines[-1].split(": ", 2)[-1].replace(path, name).replace(os.path.dirname(path) + "/", "")
        print(f"# | {name} | refused: {reason} |")
        say(len([line for line in lines if "error" in line]) == 1, f"{name}: refused in one line")
        return
    if oracle is None:
        print(f"# | {name} | read; pydicom cannot |")
        say(True, f"{name}: read, nothing to compare with")
        return
    error = compare(read[0], oracle)
    step = 8 if "rtdose" in name or "badVR" in name else 1e-6
    good = isinstance(error, float) and error <= step
    print(f"# | {name} | read; largest difference to pydicom {error} |")
    say(good, f"{name}: as pydicom reads it")


def info(source):
    done = run(VITRINE, "info", "--json", source)
    return json.loads(done.stdout) if done.stdout else None


def check_series(folder, source, name, stacks, slices, *ids):
    found = info(source)
    taken = [s for s in found["stacks"] if s["chosen"]]
    warned = {w.split(":")[0] for s in taken for w in s["warnings"]}
    print(f"# | {name} | {len(found['stacks'])} stacks; taken: {taken[0]['slices']} slices, {taken[0]['voxels']}, {sorted(warned)} |")
    say(len(found["stacks"]) == stacks and taken[0]["slices"] == slices and warned == set(ids), f"{name}: stacks and warnings")
    return taken[0]


def same_series(folder, source, name):
    """All slices of an evenly spaced series against pydicom, by position."""
    (values, directions, origin), _ = vitrine_values(folder, source)
    worst = 0.0
    for entry in sorted(os.listdir(source)):
        data = pydicom.dcmread(os.path.join(source, entry))
        k = np.linalg.solve(directions.T, np.array(data.ImagePositionPatient, float) - origin)[2]
        slope, intercept = float(data.RescaleSlope), float(data.RescaleIntercept)
        worst = max(worst, abs(k - round(k)), np.abs(values[round(k)] - (data.pixel_array * slope + intercept)).max())
    say(worst < 1e-6, f"{name}: every voxel and position as pydicom, largest difference {worst:g}")


def reencoded(folder, source, name):
    """The whole series in JPEG 2000, JPEG-LS and RLE: the same voxels, the same picture."""
    (values, _, _), _ = vitrine_values(folder, source)
    first = os.path.join(folder, "native.png")
    scene = ["--preset", "bone", "--size", "160x160", "--view", "30,20"]
    run(VITRINE, "snapshot", source, "-o", first, *scene)
    for option in ("--j2k", "--jpegls", "--rle"):
        coded = os.path.join(folder, option[2:])
        os.makedirs(coded)
        for entry in os.listdir(source):
            subprocess.run(["gdcmconv", option, os.path.join(source, entry), os.path.join(coded, entry)], check=True)
        (other, _, _), _ = vitrine_values(folder, coded)
        picture = os.path.join(folder, option[2:] + ".png")
        run(VITRINE, "snapshot", coded, "-o", picture, *scene)
        same = run(VITRINE, "compare", first, picture).returncode == 0
        say(np.array_equal(values, other) and same, f"{name} through gdcmconv {option}: voxels and picture equal")


def uneven_series(folder, source, name):
    """Every slice of a resampled stack against linear interpolation of pydicom's slices at its position. (dcm2niix makes
    an even, tilt-corrected volume of this study too, warns that it is new, and puts it elsewhere: no oracle.)"""
    (ours, directions, origin), _ = vitrine_values(folder, source)
    slices = [pydicom.dcmread(os.path.join(source, entry)) for entry in sorted(os.listdir(source))]
    orientation = np.array(slices[0].ImageOrientationPatient, float)
    normal = np.cross(orientation[:3], orientation[3:])
    places = np.array([np.array(s.ImagePositionPatient, float) for s in slices])
    order = np.argsort(places @ normal)
    along = (places @ normal)[order]
    worst = off = 0.0
    for k, image in enumerate(ours):
        at = origin + k * directions[2]
        after = int(np.clip(np.searchsorted(along, at @ normal), 1, len(along) - 1))
        weight = (at @ normal - along[after - 1]) / (along[after] - along[after - 1])
        if min(abs(along - at @ normal)) < 0.06:
            weight = round(weight)
        off = max(off, np.abs(at - (1 - weight) * places[order[after - 1]] - weight * places[order[after]]).max())
        pair, padding = [], []
        for data in (slices[order[after - 1]], slices[order[after]]):
            padding.append(data.pixel_array == int(data.PixelPaddingValue))
            pair.append(np.where(padding[-1], AIR, data.pixel_array * float(data.RescaleSlope) + float(data.RescaleIntercept)))
        mixed = np.where(padding[0] != padding[1], pair[weight > 0.5], (1 - weight) * pair[0] + weight * pair[1])
        worst = max(worst, np.abs(mixed - image).max())
    say(worst <= 0.5 + 1e-6 and off < 0.07, f"{name}: {len(ours)} slices from {len(slices)}: as interpolated by numpy, largest difference "
        f"{worst:.3f} HU, places within {off:.3f} mm")


def main(data):
    with tempfile.TemporaryDirectory() as folder:
        for where in ("awkward/cornerstone_CTImage_all_ts", "awkward/pydicom_test_files"):
            for entry in sorted(os.listdir(os.path.join(data, where))):
                path = os.path.join(data, where, entry)
                if os.path.isfile(path):
                    check_file(folder, path, entry)
        chest, ge, philips = (os.path.join(data, p) for p in ("lungfcp_98/dicom", "dcm_qa_ct/GE_tilt_unequal", "dcm_qa_ct/Philips_mixed"))
        check_series(folder, chest, "lungfcp_98", 1, 98)
        same_series(folder, chest, "lungfcp_98")
        check_series(folder, philips, "Philips_mixed", 3, 28)
        check_series(folder, ge, "GE_tilt_unequal", 1, 28, "spacing-uneven", "gantry-tilt")
        uneven_series(folder, ge, "GE_tilt_unequal")
        reencoded(folder, chest, "lungfcp_98")
    finish()


main(sys.argv[1])
