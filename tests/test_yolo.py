"""The detector yolo: networks in the manner of YOLOv5 and YOLOv8 from ONNX files, written by hand here."""

import numpy as np
import pytest

from tests.onnx_network import write_network
from vbbench.boxes import overlaps
from vbbench.errors import FileError, VbbenchError
from vbbench.exchange.detection import make_detector
from vbbench_renderers.onnx_header import read_onnx_header
from vbbench_renderers.yolo import letterboxed, read_output

BOXES = np.array([[20.0, 30.0, 8.0, 20.0], [44.0, 32.0, 10.0, 24.0], [44.5, 32.0, 10.0, 24.0]])
SCORES = np.array([0.9, 0.6, 0.5])
COUNT, CLASSES = 120, 3


def version8(scores=SCORES, person=0, boxes=BOXES):
    """[1, 4 + classes, N]: three boxes of the class ``person``, and many that are nothing."""
    output = np.zeros((1, 4 + CLASSES, COUNT))
    output[0, :4, : len(boxes)] = boxes.T
    output[0, 4 + person, : len(scores)] = scores
    output[0, 4 + (person + 1) % CLASSES, 50] = 0.99
    return output


def version5():
    """[1, N, 5 + classes] of the same boxes."""
    output = np.zeros((1, COUNT, 5 + CLASSES))
    output[0, :3, :4], output[0, :3, 4], output[0, :3, 5] = BOXES, 0.95, SCORES / 0.95
    return output


def picture(width, height, colour=(255, 0, 0)):
    return np.broadcast_to(np.array(colour, np.uint8), (height, width, 3)).copy()


@pytest.mark.parametrize("output", [version8(), version5()], ids=["YOLOv8", "YOLOv5"])
@pytest.mark.parametrize(("width", "height"), [(640, 360), (100, 400), (64, 64), (30, 20)])
def test_boxes_are_those_of_the_network_in_px_of_the_picture(tmp_path, output, width, height):
    found = make_detector("yolo", write_network(tmp_path / "net.onnx", output)).detect(picture(width, height))
    scale = 64 / max(width, height)
    margin = 0.5 * (64 - scale * np.array([width, height]))
    centres = found.boxes[:, :2] + 0.5 * found.boxes[:, 2:]
    np.testing.assert_allclose(centres * scale + margin, BOXES[:2, :2], atol=1.0)  # margins are whole px
    np.testing.assert_allclose(found.boxes[:, 2:] * scale, BOXES[:2, 2:], rtol=1e-5)
    np.testing.assert_allclose(found.scores, SCORES[:2], rtol=1e-5)
    assert overlaps(found.boxes[:1], found.boxes[1:]) < 0.6


def test_pictures_are_rgb_from_0_to_1_in_grey_margins(tmp_path):
    slope = np.zeros((1, 4 + CLASSES, COUNT, 3))
    slope[0, 4, 0], slope[0, 4, 1], slope[0, 4, 2] = np.eye(3)
    boxes = np.array([[10.0, 30, 8, 20], [30.0, 30, 8, 20], [50.0, 30, 8, 20]])
    net = write_network(tmp_path / "net.onnx", version8(scores=np.zeros(3), boxes=boxes), slope)
    found = make_detector(str(net)).detect(picture(64, 32, (200, 100, 60)))
    by_place = found.scores[np.argsort(found.boxes[:, 0])]
    np.testing.assert_allclose(by_place, (np.array([200, 100, 60]) + 114) / 510, atol=2e-3)


def test_the_class_of_people_is_found_by_its_name(tmp_path):
    net = write_network(tmp_path / "a.onnx", version8(person=2), names={0: "dog", 1: "car", 2: "Person"})
    np.testing.assert_allclose(make_detector("yolo", net).detect(picture(64, 64)).scores, SCORES[:2], rtol=1e-5)
    with pytest.raises(FileError, match="has no class 'person'; its classes: dog, car"):
        make_detector(str(write_network(tmp_path / "b.onnx", version8(), names={0: "dog", 1: "car"})))


def test_a_network_of_any_size_gets_640_px_and_its_header_is_read(tmp_path):
    net = write_network(tmp_path / "net.onnx", version8(), side="height")
    assert read_onnx_header(net).shape == (1, 3, None, None)
    assert make_detector(str(net)).detect(picture(320, 640)).boxes[0, 3] == pytest.approx(BOXES[0, 3])
    assert read_onnx_header(write_network(net, version8(), side=64)).shape == (1, 3, 64, 64)


def test_a_panorama_is_continued_beyond_its_seam(tmp_path):
    net = write_network(tmp_path / "net.onnx", version8(boxes=np.array([[60.0, 32, 8, 20], [5.14, 32, 8, 20]])))
    found = make_detector(str(net)).detect(picture(600, 100), period=600.0)
    assert len(found.boxes) == 1  # both are the same place, a turn apart
    assert found.boxes[0, 0] + 0.5 * found.boxes[0, 2] == pytest.approx(60 * 700 / 64)


def test_letterbox_keeps_the_shape_of_the_picture():
    shown, where = letterboxed(picture(200, 100), (64, 96))
    assert shown.shape == (96, 64, 3)
    assert (where.scale, where.left, where.top) == (0.32, 0, 32)
    assert (shown[:32] == 114).all()
    assert (shown[32:64] == [255, 0, 0]).all()


@pytest.mark.parametrize(
    ("output", "message"),
    [
        (np.zeros((1, 3, COUNT)), r"its output has the shape \[1, 3, 120\]; wanted: \[1, N, 5 \+ classes\] of YOLOv5"),
        (np.zeros((1, 30, 6)), r"its output has the shape \[1, 30, 6\]"),
        (version8(scores=np.array([7.0])), r"its scores are 0 to 7, not 0 to 1"),
        (version8(boxes=BOXES / 64), "its boxes are shares of the picture, not px"),
    ],
)
def test_an_output_of_another_kind_is_one_clear_line(tmp_path, output, message):
    detector = make_detector(str(write_network(tmp_path / "net.onnx", output)))
    with pytest.raises(FileError, match=message) as caught:
        detector.detect(picture(64, 64))
    assert "\n" not in str(caught.value)
    assert "net.onnx" in str(caught.value)


def test_a_class_that_the_output_does_not_have_is_refused(tmp_path):
    with pytest.raises(FileError, match="has no class 7"):
        read_output(tmp_path / "net.onnx", version8(), 7)


@pytest.mark.parametrize(
    ("shape", "message"),
    [
        ((1, 12), r"its input has the shape \[1, 12\]; wanted: \[1, 3, height, width\]"),
        ((4, 3, 64, 64), r"its input has the shape \[4, 3, 64, 64\]"),
    ],
)
def test_an_input_of_another_kind_is_one_clear_line(tmp_path, shape, message):
    with pytest.raises(FileError, match=message):
        make_detector(str(write_network(tmp_path / "net.onnx", version8(), shape=shape)))


def test_what_is_no_network_is_one_clear_line(tmp_path):
    with pytest.raises(VbbenchError, match=r"detector yolo needs your network: --weights FILE\.onnx"):
        make_detector("yolo")
    with pytest.raises(FileError, match=r"none\.onnx: cannot be read"):
        make_detector(str(tmp_path / "none.onnx"))
    with pytest.raises(VbbenchError, match="are two networks; name one"):
        make_detector("a.onnx", tmp_path / "b.onnx")
    with pytest.raises(VbbenchError, match="detector 'hog' is not a class that is called with weights=FILE"):
        make_detector("hog", tmp_path / "b.onnx")
    whole = write_network(tmp_path / "net.onnx", version8()).read_bytes()
    for n, data in enumerate((b"", b"PK\3\4 some zip", b"\xff" * 40, whole[: len(whole) // 2])):
        (tmp_path / f"{n}.onnx").write_bytes(data)
        with pytest.raises(FileError, match="is not an ONNX network; export yours with format=onnx"):
            make_detector(str(tmp_path / f"{n}.onnx"))


def test_a_network_that_opencv_cannot_run_is_one_clear_line(tmp_path):
    path = write_network(tmp_path / "net.onnx", version8())
    path.write_bytes(path.read_bytes().replace(b"GlobalAveragePool", b"GlobalAveragePoll"))
    with pytest.raises(FileError, match=r"OpenCV cannot (read|run) this network") as caught:
        make_detector(str(path)).detect(picture(64, 64))
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("numbers", [[0, 0, 0], [0, 1, 0], [1, 1, 1], [56, 0, 2]])
def test_output_after_a_suppression_is_refused(tmp_path, numbers):
    """Corners, score and the number of the class, as networks have it that were exported with their own suppression."""
    output = np.zeros((1, COUNT, 6))
    output[0, :3, :2], output[0, :3, 2:4] = BOXES[:, :2] - 0.5 * BOXES[:, 2:], BOXES[:, :2] + 0.5 * BOXES[:, 2:]
    output[0, :3, 4], output[0, :3, 5] = SCORES, numbers
    with pytest.raises(FileError, match="ends in numbers of classes, as after a suppression of its own; wanted"):
        read_output(tmp_path / "net.onnx", output, 0)
