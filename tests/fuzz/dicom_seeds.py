#!/usr/bin/python3
"""dicom_seeds.py FOLDER - writes the synthetic files of tests/fuzz/seeds/dicom that hold more than dicom_fixture.h can
write: JPEG 2000, multi-frame, float pixels, DICOMDIR. Needs python3-pydicom, numpy and gdcmconv (libgdcm-tools). The
files are kept in the tree; this is where they came from. tests/unit/dicom_frames_test.c knows the values:
stored(frame, row, column) = 100 * frame + 10 * row + column - 20, signed 16 bits, HU = stored * 2 - 100."""
import os
import subprocess
import sys
from io import BytesIO

import numpy as np
from pydicom.dataelem import DataElement
from pydicom.datadict import tag_for_keyword
from pydicom.dataset import Dataset, FileMetaDataset
from pydicom.encaps import encapsulate
from pydicom.filebase import DicomFileLike
from pydicom.filewriter import write_dataset, write_file_meta_info
from pydicom.sequence import Sequence
from pydicom.tag import Tag
from pydicom.uid import ExplicitVRBigEndian, ExplicitVRLittleEndian, ImplicitVRLittleEndian, JPEG2000Lossless

ROWS, COLUMNS = 6, 10


def cells(frame):
    row, column = np.mgrid[0:ROWS, 0:COLUMNS]
    return (100 * frame + 10 * row + column - 20).astype("<i2")


def base(sop_class):
    data = Dataset()
    data.file_meta = FileMetaDataset()
    data.file_meta.MediaStorageSOPClassUID = sop_class
    data.file_meta.MediaStorageSOPInstanceUID = "2.25.1"
    data.file_meta.TransferSyntaxUID = ExplicitVRLittleEndian
    data.is_little_endian, data.is_implicit_VR = True, False
    data.SOPClassUID, data.SOPInstanceUID = sop_class, "2.25.1"
    data.StudyInstanceUID, data.SeriesInstanceUID = "2.25.2", "2.25.3"
    data.Modality, data.SeriesNumber, data.InstanceNumber = "CT", 1, 1
    data.SamplesPerPixel, data.PhotometricInterpretation = 1, "MONOCHROME2"
    data.Rows, data.Columns = ROWS, COLUMNS
    data.BitsAllocated, data.BitsStored, data.HighBit, data.PixelRepresentation = 16, 16, 15, 1
    return data


def item(**attributes):
    group = Dataset()
    for name, value in attributes.items():
        setattr(group, name, value)
    return Sequence([group])


def single():
    data = base("1.2.840.10008.5.1.4.1.1.2")
    data.ImagePositionPatient, data.ImageOrientationPatient = [0, 0, 0], [1, 0, 0, 0, 1, 0]
    data.PixelSpacing, data.SliceThickness = [1, 1], 2
    data.RescaleSlope, data.RescaleIntercept, data.RescaleType = 2, -100, "HU"
    data.PixelData = cells(0).tobytes()
    return data


def enhanced(frames, phases=1):
    """Frames lie at z = 3 * place; spacing is shared, orientation and rescale are each frame's own."""
    data = base("1.2.840.10008.5.1.4.1.1.2.1")
    data.NumberOfFrames = frames
    shared = Dataset()
    shared.PixelMeasuresSequence = item(PixelSpacing=[0.5, 0.75], SliceThickness=3)
    data.SharedFunctionalGroupsSequence = Sequence([shared])
    groups = []
    for f in range(frames):
        group = Dataset()
        place, phase = f // phases, f % phases
        group.FrameContentSequence = item(StackID="1", InStackPositionNumber=place + 1, TemporalPositionIndex=phase + 1)
        group.PlanePositionSequence = item(ImagePositionPatient=[5, 6, 3 * place])
        group.PlaneOrientationSequence = item(ImageOrientationPatient=[1, 0, 0, 0, 1, 0])
        group.PixelValueTransformationSequence = item(RescaleIntercept=-100, RescaleSlope=2, RescaleType="HU")
        group.CTImageFrameTypeSequence = item(FrameType=["ORIGINAL", "PRIMARY", "VOLUME", "NONE"])
        groups.append(group)
    data.PerFrameFunctionalGroupsSequence = Sequence(groups)
    data.PixelData = b"".join(cells(f).tobytes() for f in range(frames))
    return data


def plain_frames(frames, **attributes):
    """Several frames without functional groups; the first lies at (5, 6, 7)."""
    data = single()
    data.NumberOfFrames = frames
    data.ImagePositionPatient = [5, 6, 7]
    data.PixelData = b"".join(cells(f).tobytes() for f in range(frames))
    for name, value in attributes.items():
        setattr(data, name, value)
    return data


def gated():
    """Nuclear medicine: two slices in two time slots, place and direction with the detector, stacked downward."""
    data = plain_frames(4, Modality="NM", SOPClassUID="1.2.840.10008.5.1.4.1.1.20", SpacingBetweenSlices=-2.5,
                        FrameIncrementPointer=[0x00540070, 0x00540080], TimeSlotVector=[1, 1, 2, 2],
                        SliceVector=[1, 2, 1, 2], NumberOfSlices=2)
    data.DetectorInformationSequence = item(ImagePositionPatient=[5, 6, 7], ImageOrientationPatient=[1, 0, 0, 0, 1, 0])
    del data.ImagePositionPatient, data.ImageOrientationPatient
    return data


def looked_up(inverted=False):
    """Stored values -20..79 (and up) through a table from -10 on: 1000 + 3 * i * i; HU by the table's type."""
    data = single()
    del data.RescaleSlope, data.RescaleIntercept, data.RescaleType
    data.ModalityLUTSequence = item(LUTDescriptor=[40, 65526, 16], ModalityLUTType="US" if inverted else "HU",
                                    LUTData=[1000 + 3 * i * i for i in range(40)])
    data.ModalityLUTSequence[0]["LUTDescriptor"].VR = data.ModalityLUTSequence[0]["LUTData"].VR = "US"
    if inverted:
        data.Modality, data.PhotometricInterpretation, data.PixelPaddingValue = "PT", "MONOCHROME1", -20
        data["PixelPaddingValue"].VR = "SS"
    return data


def codestream(frame, folder):
    """One frame as a JPEG 2000 codestream, through gdcmconv."""
    data = single()
    data.PixelData = cells(frame).tobytes()
    plain, coded = os.path.join(folder, "plain"), os.path.join(folder, "coded")
    data.save_as(plain, write_like_original=False)
    subprocess.run(["gdcmconv", "--j2k", plain, coded], check=True)
    text = open(coded, "rb").read()
    start = text.index(b"\xff\x4f\xff\x51")
    os.remove(plain)
    os.remove(coded)
    return text[start:text.rindex(b"\xff\xd9") + 2]


def save(data, folder, name, pixels=None):
    if pixels is not None:
        data.file_meta.TransferSyntaxUID = JPEG2000Lossless
        data.PixelData = pixels
        data["PixelData"].is_undefined_length = True
    data.save_as(os.path.join(folder, name), write_like_original=False)


def mixed_up(folder, name, claim, implicit, little, meta=True):
    """A data set in one encoding under a meta header that says another (or none)."""
    data = single()
    if not little:
        data.PixelData = cells(0).astype(">i2").tobytes()
    body, head = BytesIO(), BytesIO()
    stream = DicomFileLike(body)
    stream.is_implicit_VR, stream.is_little_endian = implicit, little
    file_meta, data.file_meta = data.file_meta, None
    del data.file_meta
    data.is_implicit_VR, data.is_little_endian = implicit, little
    write_dataset(stream, data)
    if meta:
        stream = DicomFileLike(head)
        stream.is_implicit_VR, stream.is_little_endian = False, True
        file_meta.TransferSyntaxUID = claim
        file_meta.ImplementationClassUID = "2.25.9"
        write_file_meta_info(stream, file_meta)
    with open(os.path.join(folder, name), "wb") as out:
        out.write((bytes(128) + b"DICM" + head.getvalue() if meta else b"") + body.getvalue())


def with_vr(name, vr, value, **attributes):
    """One attribute in a VR that is not its own."""
    data = single()
    for key, what in attributes.items():
        setattr(data, key, what)
    tag = Tag(tag_for_keyword(name))
    if tag in data:
        del data[tag]
    data[tag] = DataElement(tag, vr, value)
    return data


def patched(folder, name, old, new):
    path = os.path.join(folder, name)
    text = open(path, "rb").read()
    assert text.count(old) == 1
    open(path, "wb").write(text.replace(old, new))


def odd_files(folder):
    """What other software writes: wrong VRs, decimal commas, private transfer syntaxes, 12 bits in 32."""
    save(with_vr("RescaleSlope", "LO", "2"), folder, "odd_slope_text")
    save(with_vr("PixelRepresentation", "UL", 1), folder, "odd_sign_long")
    save(with_vr("Rows", "SS", ROWS), folder, "odd_rows_signed")
    save(with_vr("PixelPaddingValue", "OB", b"\xec\xff"), folder, "odd_padding_bytes")
    save(with_vr("RescaleSlope", "DS", "7.25"), folder, "odd_comma")
    patched(folder, "odd_comma", b"7.25", b"7,25")
    save(single(), folder, "odd_syntax")
    patched(folder, "odd_syntax", b"1.2.840.10008.1.2.1\0", b"1.2.840.99999.9.9.9\0")
    data = single()
    data.BitsAllocated, data.BitsStored, data.HighBit = 32, 12, 11
    data.PixelData = (cells(0).astype("<i4") & 0xfff | 0x5000).tobytes()
    save(data, folder, "odd_bits")
    data = single()
    data.PixelData, data.is_implicit_VR = cells(0).astype(">i2").tobytes(), True
    data.file_meta.TransferSyntaxUID = ImplicitVRLittleEndian
    save(data, folder, "odd_ge_private")
    patched(folder, "odd_ge_private", b"1.2.840.10008.1.2\0", b"1.2.840.113619.5.2")


def main(folder):
    os.makedirs(folder, exist_ok=True)
    streams = [codestream(f, folder) for f in range(4)]
    save(single(), folder, "j2k", encapsulate([streams[0]]))
    save(single(), folder, "j2k_fragments", encapsulate([streams[0]], fragments_per_frame=3))
    jp2 = b"\0\0\0\x0cjP  \r\n\x87\n" + b"\0\0\0\x14ftypjp2 \0\0\0\0jp2 " + b"\0\0\0\x2djp2h" + \
        b"\0\0\0\x16ihdr" + ROWS.to_bytes(4, "big") + COLUMNS.to_bytes(4, "big") + b"\0\x01\x8f\x07\0\0" + \
        b"\0\0\0\x0fcolr\x01\0\0\0\0\0\x11" + b"\0\0\0\0jp2c" + streams[0]
    save(single(), folder, "j2k_in_jp2", encapsulate([jp2]))
    save(enhanced(4), folder, "enhanced")
    save(enhanced(4, 2), folder, "enhanced_phases")
    save(enhanced(4), folder, "enhanced_j2k", encapsulate(streams))
    save(enhanced(4), folder, "enhanced_j2k_no_table", encapsulate(streams, fragments_per_frame=2, has_bot=False))
    save(enhanced(4), folder, "enhanced_j2k_table", encapsulate(streams, fragments_per_frame=2, has_bot=True))
    save(plain_frames(4, SpacingBetweenSlices=3), folder, "frames_spacing")
    save(plain_frames(4, FrameIncrementPointer=0x00182005, SliceLocationVector=[10, 13, 16, 19]), folder, "frames_location")
    save(plain_frames(4, FrameIncrementPointer=0x3004000C, GridFrameOffsetVector=[7, 10, 13, 16]), folder, "frames_grid")
    save(plain_frames(4, FrameIncrementPointer=0x00181063, FrameTime=40, SpacingBetweenSlices=3), folder, "frames_cine")
    save(gated(), folder, "frames_gated")
    save(looked_up(), folder, "table")
    save(looked_up(True), folder, "table_inverted")
    odd_files(folder)
    mixed_up(folder, "says_implicit_is_explicit", ImplicitVRLittleEndian, False, True)
    mixed_up(folder, "says_explicit_is_implicit", ExplicitVRLittleEndian, True, True)
    mixed_up(folder, "says_big_is_little", ExplicitVRBigEndian, False, True)
    mixed_up(folder, "says_little_is_big", ExplicitVRLittleEndian, False, False)
    mixed_up(folder, "no_meta_explicit", None, False, True, meta=False)
    mixed_up(folder, "no_meta_implicit", None, True, True, meta=False)
    for name, kind, bits in (("float", "<f4", 32), ("double", "<f8", 64)):
        data = single()
        del data.PixelData
        values = cells(0).astype(kind) + 0.25
        values[0, 0] = np.nan
        if bits == 32:
            data.FloatPixelData = values.tobytes()
        else:
            data.DoubleFloatPixelData = values.tobytes()
        data.BitsAllocated = bits
        del data.BitsStored, data.HighBit, data.PixelRepresentation
        save(data, folder, name)


main(sys.argv[1])
