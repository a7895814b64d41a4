"""Fits a calibration to the binning, decimation, region and mirroring of each frame."""

from __future__ import annotations

import logging
from dataclasses import replace
from pathlib import Path

from grabbergui.calibration.camera_info import load_for, save
from grabbergui.calibration.frame_geometry import GeometryReader, Pair, pair_of
from grabbergui.core.calibration import Calibration, FrameCalibration
from grabbergui.core.errors import FeatureNotFoundError, GrabberError, UsageError
from grabbergui.core.frame import Frame
from grabbergui.core.grabber import FrameGrabber
from grabbergui.core.image_geometry import ImageGeometry
from grabbergui.core.sfnc import Role

log = logging.getLogger(__name__)

_NONE = "the camera has no calibration; serve it with --calibration FILE"
_SHAPE_TOLERANCE = 0.01
"""Relative difference of aspect ratios up to which images count as the same, scaled."""


class FittedCalibration:
    """A camera's calibration, shared by all that serve, show or record its images. Any thread.

    A calibration that does not record the geometry of its images counts as one of images as the camera was
    set when the first of that size came, or of the whole sensor if it has the sensor's size or shape.
    """

    def __init__(self, grabber: FrameGrabber, file: Path | None = None) -> None:
        """Begin with the calibration of `file`, as `use` does."""
        self.calibration: Calibration | None = None
        "The calibration as it was made; None without one."
        self._grabber = grabber
        self._geometries = GeometryReader(grabber)
        self._file: Path | None = None
        self._refused = ""
        "Why the file was not loaded; empty if it was, or if there is none yet."
        self._assumed: tuple[Calibration | None, Calibration | None] = (None, None)
        "A calibration that does not record its geometry, and the same with the one that it counts as."
        self._fitted: tuple[object, FrameCalibration | UsageError | None] = (None, None)
        "Geometry to which the calibration was fitted last, and the result; exchanged as one."
        self._warned: UsageError | None = None
        "The result of which `forms` has warned."
        if file is not None:
            self.use(file)

    @property
    def file(self) -> Path | None:
        """The file that `keep` writes; None if the calibration is only in memory."""
        return self._file

    def use(self, file: Path) -> None:
        """Load `file` if it exists; `keep` writes it from now on.

        A file that is refused stops no camera: there is a warning, images are sent without a calibration, and
        the file is left as it is.
        """
        self._file, self._refused = file, ""
        try:
            if file.exists():
                self.calibration = load_for(self._grabber.info, file)
        except (UsageError, OSError) as error:
            self._refused = str(error)
            log.warning("%s; images are sent without this calibration", error)

    def close(self) -> None:
        """Release the grabber. May be called twice."""
        self._geometries.close()

    def keep(self, calibration: Calibration) -> Path | None:
        """Use another calibration, made with the current settings; save it in the file, and return that.

        Raises OSError, and UsageError rather than replace a file that was refused or write one that would be.
        """
        calibration = replace(
            calibration.made_with(self._grabber.info), geometry=self._geometry_of_new(calibration)
        )
        if self._file is not None:
            if self._refused and self._file.exists():
                raise UsageError(
                    f"{self._file} is kept, as it could not be loaded ({self._refused}); rename or remove it"
                )
            save(calibration, self._file)
        self.calibration = calibration
        return self._file

    def assume_settings(self) -> None:
        """Let a calibration that does not record its geometry count as one of images as set now.

        Otherwise the first frame of its size decides, and does if the size is another now.
        """
        try:
            size, geometry = self._size(), self._geometries.now()
            if self.calibration is not None and size is not None and geometry is not None:
                self._located(self.calibration, size, geometry, assume=True)
        except GrabberError as error:
            log.debug("%s", error)

    def of(self, frame: Frame) -> Calibration | None:
        """Return the calibration of a frame; None, with one warning, if it cannot be determined.

        Without a calibration here, it is the one that the source reports.
        """
        found = self.forms(frame)
        return None if found is None else found.image

    def forms(self, frame: Frame) -> FrameCalibration | None:
        """Return the calibration of a frame, as `of`, also in ROS's form."""
        try:
            return self.fit(frame)
        except UsageError as error:
            if error is not self._warned:
                self._warned = error
                log.warning("images are sent without a calibration: %s", error)
            return None

    def fit(self, frame: Frame) -> FrameCalibration | None:
        """Return the calibration of a frame; None without one, or while the camera does not answer.

        Raises UsageError if it cannot be fitted to the frame.
        """
        size = (frame.width, frame.height)
        calibration = self.calibration
        if calibration is None:
            own = self._own(size)
            return None if own is None else FrameCalibration(own, own)
        try:
            geometry = self._geometries.of(frame)
        except GrabberError as error:
            log.debug("the geometry of the images is not known: %s", error)
            return None
        key = (calibration, size, geometry)
        last_key, result = self._fitted
        if key != last_key:
            try:
                result = self._fit(calibration, size, geometry, assume=True)
            except UsageError as error:
                result = error
            self._fitted = key, result
        if isinstance(result, UsageError):
            raise result.with_traceback(None)  # otherwise it would grow with each frame
        return result

    def now(self) -> Calibration:
        """Return the calibration of images with the camera's current settings.

        Raises FeatureNotFoundError without one, UsageError if it does not fit the region.
        """
        size = self._size()
        if size is None:
            raise FeatureNotFoundError("the camera does not report the size of its images", "Width")
        return self._of_size(size, assume=False)

    def of_size(self, width: int, height: int) -> Calibration:
        """Return the calibration of the images of this size that the camera sends with its current settings.

        Raises as `now`.
        """
        return self._of_size((width, height), assume=True)

    def _of_size(self, size: Pair, *, assume: bool) -> Calibration:
        calibration = self.calibration
        if calibration is None:
            own = self._own(size)
            if own is None:
                raise FeatureNotFoundError(_NONE, "calibration")
            return own
        return self._fit(calibration, size, self._geometries.now(), assume=assume).image

    def _own(self, size: Pair) -> Calibration | None:
        own = self._grabber.calibration()
        return own if own and (own.width, own.height) == size else None

    def _size(self) -> Pair | None:
        return pair_of(self._grabber, (self._grabber.role(Role.WIDTH), self._grabber.role(Role.HEIGHT)))

    def _fit(
        self, calibration: Calibration, size: Pair, geometry: ImageGeometry | None, *, assume: bool = False
    ) -> FrameCalibration:
        if geometry is None:
            image = calibration.scaled_to(*size)
            return FrameCalibration(image, image)
        return _forms(self._located(calibration, size, geometry, assume), size, geometry)

    def _located(
        self, calibration: Calibration, size: Pair, geometry: ImageGeometry, assume: bool
    ) -> Calibration:
        """Return the calibration with the geometry of its images, recorded or assumed.

        With `assume`, the assumption is kept if the sizes allow it. Raises UsageError.
        """
        if calibration.geometry is not None:
            return calibration
        known, located = self._assumed
        if known is calibration and located is not None:
            return located
        assumed = assumed_geometry(calibration, size, geometry)
        located = replace(calibration, geometry=assumed)
        if assume and (size == (calibration.width, calibration.height) or assumed.binning == (1, 1)):
            self._assumed = calibration, located
            log.info(
                "the calibration does not record the region and binning of its images; "
                "they count as those that are set now"
            )
        return located

    def _geometry_of_new(self, calibration: Calibration) -> ImageGeometry | None:
        if calibration.geometry is not None:
            return calibration.geometry
        try:
            size, geometry = self._size(), self._geometries.now()
            return assumed_geometry(calibration, size, geometry) if size and geometry else None
        except GrabberError as error:
            log.info("the calibration is kept without the geometry of its images: %s", error)
            return None


def assumed_geometry(calibration: Calibration, size: Pair, geometry: ImageGeometry) -> ImageGeometry:
    """Return the geometry that a calibration without one has, by images of `size` that have `geometry`.

    It is the same for images of the same size. Images of the whole sensor, or of its shape, are all of it.
    Raises UsageError for others.
    """
    calibrated = calibration.width, calibration.height
    if calibrated == size:
        return geometry
    along_x, along_y = (ours / theirs for ours, theirs in zip(geometry.sensor, calibrated, strict=True))
    if abs(along_x - along_y) > _SHAPE_TOLERANCE * along_y:
        raise calibration.of_another_crop(*size)
    whole = ImageGeometry(calibrated, (0, 0), (1, 1), geometry.reversed)
    return whole if whole.same_sensor(geometry) else replace(whole, binning=(along_x, along_y))


def fitted(calibration: Calibration, size: Pair, geometry: ImageGeometry) -> Calibration:
    """Fit a calibration, which has a geometry, to images of `size` with another.

    One of exactly these images is returned unchanged. Raises UsageError if the two cannot be compared.
    """
    made = calibration.geometry
    if made is None:
        raise UsageError("the calibration does not record the geometry of its images")
    if made == geometry and size == (calibration.width, calibration.height):
        return calibration
    if made.same_sensor(geometry):
        scale_x, scale_y = (old / new for old, new in zip(made.binning, geometry.binning, strict=True))
    else:  # The camera scales by something else than its binning.
        scale_x, scale_y = (new / old for old, new in zip(made.whole, geometry.whole, strict=True))
        if abs(scale_x - scale_y) > _SHAPE_TOLERANCE * scale_y:
            raise calibration.of_another_crop(*size)
    x, y = made.offset
    whole = calibration.cut_out(-x, -y, *made.whole)
    mirror = made.reversed[0] != geometry.reversed[0], made.reversed[1] != geometry.reversed[1]
    if any(mirror):
        # Mirrored about the middle of the sensor, of which binning may leave out the last pixels.
        edges = (
            max(old, new / scale)
            for old, new, scale in zip(made.whole, geometry.whole, (scale_x, scale_y), strict=True)
        )
        whole = whole.mirrored(mirror, (next(edges), next(edges)))
    whole = whole.resampled(*geometry.whole, (scale_x, scale_y))
    return replace(whole.cut_out(*geometry.offset, *size), geometry=geometry)


def _forms(calibration: Calibration, size: Pair, geometry: ImageGeometry) -> FrameCalibration:
    image, made = fitted(calibration, size, geometry), calibration.geometry
    across, down = geometry.binning
    if image is calibration or made is None or not made.same_sensor(geometry):
        return FrameCalibration(image, image)
    if across % 1 or down % 1:
        return FrameCalibration(image, image)
    across, down = int(across), int(down)
    sensor = made.whole if made.binning == (1, 1) else (geometry.whole[0] * across, geometry.whole[1] * down)
    try:
        full = fitted(calibration, sensor, ImageGeometry(sensor, reversed=geometry.reversed))
    except UsageError:  # larger than any image may be
        return FrameCalibration(image, image)
    x, y = geometry.offset
    part = (x * across, y * down, size[0] * across, size[1] * down)
    whole = geometry.offset == (0, 0) and size == geometry.whole
    return FrameCalibration(image, full, None if whole else part, (across, down))
