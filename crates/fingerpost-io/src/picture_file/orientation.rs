//! How a picture is to be turned to stand upright, by its Exif data (CIPA DC-008, "Exif 2.32", tag Orientation).
//!
//! Calibrations are of pictures as they are shown, as of videos, whose display matrix ffmpeg applies. Exif data that are broken say
//! nothing.

use fingerpost_vision::picture::RgbImage;

/// The tag and its type, a number of 16 bits.
const TAG: u16 = 0x0112;
const SHORT: u16 = 3;
/// Bytes of an entry of a directory.
const ENTRY_BYTES: usize = 12;

/// How the stored rows and columns lie in the upright picture; named by where the stored top row and left column are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Orientation {
    TopLeft,
    TopRight,
    BottomRight,
    BottomLeft,
    LeftTop,
    RightTop,
    RightBottom,
    LeftBottom,
}

impl Orientation {
    /// In the order of their numbers, from 1.
    const ALL: [Self; 8] = [
        Self::TopLeft,
        Self::TopRight,
        Self::BottomRight,
        Self::BottomLeft,
        Self::LeftTop,
        Self::RightTop,
        Self::RightBottom,
        Self::LeftBottom,
    ];

    /// What Exif data say, which are a TIFF file of their own; as stored where they say nothing that is understood.
    pub(super) fn of_exif(tiff: &[u8]) -> Self {
        Self::stated(tiff).unwrap_or(Self::TopLeft)
    }

    fn stated(tiff: &[u8]) -> Option<Self> {
        let bytes = Bytes { tiff, is_big_endian: tiff.starts_with(b"MM\0*") };
        if !bytes.is_big_endian && !tiff.starts_with(b"II*\0") {
            return None;
        }
        let directory = usize::try_from(bytes.u32(4)?).ok()?;
        let entries = usize::from(bytes.u16(directory)?);
        let first = directory.checked_add(2)?;
        let entry = (0..entries)
            .map_while(|index| first.checked_add(ENTRY_BYTES * index))
            .take_while(|entry| bytes.u16(*entry).is_some())
            .find(|entry| bytes.u16(*entry) == Some(TAG))?;
        let is_number = bytes.u16(entry + 2) == Some(SHORT) && bytes.u32(entry + 4) == Some(1);
        let number = usize::from(bytes.u16(entry + 8).filter(|_| is_number)?);
        Self::ALL.get(number.checked_sub(1)?).copied()
    }

    /// The picture upright.
    pub(super) fn upright(self, stored: RgbImage) -> RgbImage {
        if self == Self::TopLeft {
            return stored;
        }
        let (width, height) = stored.size();
        let is_turned = matches!(self, Self::LeftTop | Self::RightTop | Self::RightBottom | Self::LeftBottom);
        let (to_width, to_height) = if is_turned { (height, width) } else { (width, height) };
        let (pixels, _) = stored.as_slice().as_chunks::<{ RgbImage::CHANNELS }>();
        let mut upright = RgbImage::new(to_width, to_height);
        let (places, _) = upright.as_mut_slice().as_chunks_mut::<{ RgbImage::CHANNELS }>();
        for (y, row) in places.chunks_exact_mut(to_width.max(1)).enumerate() {
            for (x, place) in row.iter_mut().enumerate() {
                let (column, line) = match self {
                    Self::TopLeft => (x, y),
                    Self::TopRight => (width - 1 - x, y),
                    Self::BottomRight => (width - 1 - x, height - 1 - y),
                    Self::BottomLeft => (x, height - 1 - y),
                    Self::LeftTop => (y, x),
                    Self::RightTop => (y, height - 1 - x),
                    Self::RightBottom => (width - 1 - y, height - 1 - x),
                    Self::LeftBottom => (width - 1 - y, x),
                };
                *place = pixels[line * width + column];
            }
        }
        upright
    }
}

/// Numbers in a TIFF file's order of bytes; none beyond its end.
struct Bytes<'a> {
    tiff: &'a [u8],
    is_big_endian: bool,
}

impl Bytes<'_> {
    fn u16(&self, at: usize) -> Option<u16> {
        let bytes = *self.tiff.get(at..)?.first_chunk()?;
        Some(if self.is_big_endian { u16::from_be_bytes(bytes) } else { u16::from_le_bytes(bytes) })
    }

    fn u32(&self, at: usize) -> Option<u32> {
        let bytes = *self.tiff.get(at..)?.first_chunk()?;
        Some(if self.is_big_endian { u32::from_be_bytes(bytes) } else { u32::from_le_bytes(bytes) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Exif data with another tag before that of the orientation.
    fn exif(is_big_endian: bool, number: u16) -> Vec<u8> {
        let u16 = |n: u16| if is_big_endian { n.to_be_bytes() } else { n.to_le_bytes() };
        let u32 = |n: u32| if is_big_endian { n.to_be_bytes() } else { n.to_le_bytes() };
        let mut tiff = if is_big_endian { b"MM".to_vec() } else { b"II".to_vec() };
        tiff.extend(u16(42));
        tiff.extend(u32(8));
        tiff.extend(u16(2));
        for (tag, kind, value) in [(0x0100, 3, 640), (TAG, SHORT, number)] {
            tiff.extend([u16(tag), u16(kind)].concat());
            tiff.extend(u32(1));
            tiff.extend([u16(value), u16(0)].concat());
        }
        tiff.extend(u32(0));
        tiff
    }

    #[test]
    fn every_number_is_read_in_both_orders_of_bytes() {
        for is_big_endian in [false, true] {
            for (number, orientation) in (1..).zip(Orientation::ALL) {
                assert_eq!(Orientation::of_exif(&exif(is_big_endian, number)), orientation);
            }
        }
    }

    #[test]
    fn what_is_broken_says_nothing() {
        let whole = exif(false, 6);
        for end in 0..whole.len() - 6 {
            assert_eq!(Orientation::of_exif(&whole[..end]), Orientation::TopLeft, "{end}");
        }
        for number in [0, 9, u16::MAX] {
            assert_eq!(Orientation::of_exif(&exif(true, number)), Orientation::TopLeft);
        }
        for (at, byte) in [(0, b'X'), (2, 0), (4, 0xff), (7, 0xff), (8, 0), (24, 9), (26, 0xff)] {
            let mut broken = whole.clone();
            broken[at] = byte;
            assert_eq!(Orientation::of_exif(&broken), Orientation::TopLeft, "{at}");
        }
    }

    /// Expected: the letter F, stored as cameras hold it, is an F again. Exif's own figure, by hand.
    #[test]
    fn every_orientation_stands_upright() {
        let upright = ["##", "#.", "##", "#."];
        let stored: [&[&str]; 8] = [
            &["##", "#.", "##", "#."],
            &["##", ".#", "##", ".#"],
            &[".#", "##", ".#", "##"],
            &["#.", "##", "#.", "##"],
            &["####", "#.#."],
            &["#.#.", "####"],
            &[".#.#", "####"],
            &["####", ".#.#"],
        ];
        let picture = |rows: &[&str]| {
            let pixels = rows.iter().flat_map(|row| row.bytes()).flat_map(|byte| [byte; 3]).collect();
            RgbImage::from_vec(rows[0].len(), rows.len(), pixels).unwrap()
        };
        for (orientation, rows) in Orientation::ALL.into_iter().zip(stored) {
            assert_eq!(orientation.upright(picture(rows)), picture(&upright), "{orientation:?}");
        }
    }
}
