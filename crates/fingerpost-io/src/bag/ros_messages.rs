//! ROS 2 messages in CDR. Source: the `.msg` files of ROS 2 `common_interfaces`, whose fields stand here in their order.

use std::sync::Arc;

use fingerpost_format::CameraInfo;

use super::cdr::{Cdr, CdrError};
use super::frame_names::{MOST_FRAMES, bounded};
use super::frames::StaticTransform;
use super::message::{Content, GpsPosition, Inertial, Message, MessageError, Twist};
use super::picture::{Picture, PixelLayout};
use super::schema::Schema;

/// Nanoseconds in a second.
const SECOND_NS: u64 = 1_000_000_000;

/// The values of a message in CDR.
pub(crate) fn decode(schema: Schema, data: &[u8]) -> Result<Message, MessageError> {
    let of_schema = |cause| MessageError::Cdr { name: schema.name(), cause };
    let mut cdr = Cdr::new(data).map_err(of_schema)?;
    // These have no header of their own.
    let Header { stamp_ns, frame_id } = match schema {
        Schema::RosTwist | Schema::RosTransforms => Header::default(),
        _ => header(&mut cdr).map_err(of_schema)?,
    };
    let content = match schema {
        Schema::RosImage => image(&mut cdr, &of_schema)?,
        Schema::RosCompressedImage => Content::Picture(
            compressed_image(&mut cdr)
                .map_err(of_schema)
                .and_then(|(format, bytes)| Ok(Picture::packed(format, bytes)?))?,
        ),
        Schema::RosCameraInfo => camera_info(&mut cdr, &of_schema)?,
        Schema::RosNavSatFix => nav_sat_fix(&mut cdr).map_err(of_schema)?,
        Schema::RosImu => imu(&mut cdr, bounded(frame_id)?).map_err(of_schema)?,
        Schema::RosOdometry => {
            let child_frame_id = odometry_frame(&mut cdr).map_err(of_schema)?;
            twist(&mut cdr, bounded(child_frame_id)?).map_err(of_schema)?
        }
        Schema::RosTransforms => transforms(&mut cdr, &of_schema)?,
        _ => twist(&mut cdr, bounded(frame_id)?).map_err(of_schema)?,
    };
    Ok(Message { stamp_ns, content })
}

/// `std_msgs/Header`.
#[derive(Debug, Default)]
struct Header<'a> {
    /// None for a stamp of zero.
    stamp_ns: Option<u64>,
    frame_id: &'a str,
}

fn header<'a>(cdr: &mut Cdr<'a>) -> Result<Header<'a>, CdrError> {
    let (seconds, nanoseconds) = (cdr.i32()?, cdr.u32()?);
    let frame_id = cdr.text()?;
    let seconds = u64::try_from(seconds).unwrap_or_default();
    let stamp_ns = seconds.saturating_mul(SECOND_NS).saturating_add(u64::from(nanoseconds));
    Ok(Header { stamp_ns: (stamp_ns > 0).then_some(stamp_ns), frame_id })
}

fn image(cdr: &mut Cdr<'_>, of_schema: &impl Fn(CdrError) -> MessageError) -> Result<Content, MessageError> {
    let mut read = || {
        let (height, width) = (cdr.u32()? as usize, cdr.u32()? as usize);
        let encoding = cdr.text()?;
        let _is_bigendian = cdr.u8()?;
        let step = cdr.u32()? as usize;
        Ok((PixelLayout { width, height, step, encoding }, cdr.blob()?))
    };
    let (layout, data) = read().map_err(of_schema)?;
    Ok(Content::Picture(Picture::raw(&layout, data)?))
}

fn compressed_image<'a>(cdr: &mut Cdr<'a>) -> Result<(&'a str, &'a [u8]), CdrError> {
    Ok((cdr.text()?, cdr.blob()?))
}

fn camera_info(
    cdr: &mut Cdr<'_>,
    of_schema: &impl Fn(CdrError) -> MessageError,
) -> Result<Content, MessageError> {
    let mut read = || {
        let (height, width) = (cdr.u32()? as usize, cdr.u32()? as usize);
        let distortion_model = cdr.text()?.to_owned();
        let distortion = cdr.numbers()?;
        let matrix = cdr.array()?;
        let _rectification: [f64; 9] = cdr.array()?;
        let projection = cdr.array()?;
        let binning_px = [cdr.u32()?, cdr.u32()?];
        let region = [cdr.u32()?, cdr.u32()?, cdr.u32()?, cdr.u32()?];
        Ok((
            CameraInfo { width, height, distortion_model, distortion, matrix, projection },
            binning_px,
            region,
        ))
    };
    let (info, binning_px, [x_offset, y_offset, region_height, region_width]) = read().map_err(of_schema)?;
    // A region of no size is the whole picture.
    let whole = [region_height as usize, region_width as usize] == [info.height, info.width]
        || (region_height == 0 && region_width == 0);
    if binning_px.iter().any(|side| *side > 1) || x_offset > 0 || y_offset > 0 || !whole {
        return Err(MessageError::Binned { binning_px });
    }
    Ok(Content::Calibration(info))
}

fn nav_sat_fix(cdr: &mut Cdr<'_>) -> Result<Content, CdrError> {
    let status = cdr.i8()?;
    let _service = cdr.u16()?;
    let (lat_deg, lon_deg) = (cdr.f64()?, cdr.f64()?);
    // STATUS_NO_FIX is -1 and STATUS_UNKNOWN -2.
    Ok(Content::Gps((status >= 0).then_some(GpsPosition { lat_deg, lon_deg })))
}

fn imu(cdr: &mut Cdr<'_>, frame_id: Arc<str>) -> Result<Content, CdrError> {
    let _orientation: [f64; 4] = cdr.array()?;
    let _orientation_covariance: [f64; 9] = cdr.array()?;
    let angular_rps = cdr.array()?;
    let turn_covariance: [f64; 9] = cdr.array()?;
    let acceleration_mps2 = cdr.array()?;
    let acceleration_covariance: [f64; 9] = cdr.array()?;
    // A first element of -1 says that there is no such measurement.
    let is_measured = |[first, ..]: [f64; 9]| first >= 0.0;
    let acceleration_mps2 = is_measured(acceleration_covariance).then_some(acceleration_mps2);
    let inertial = Inertial { frame_id, angular_rps, acceleration_mps2 };
    Ok(Content::Inertial(is_measured(turn_covariance).then_some(inertial)))
}

/// `geometry_msgs/Twist`: linear, angular. What may follow is its covariance.
fn twist(cdr: &mut Cdr<'_>, frame_id: Arc<str>) -> Result<Content, CdrError> {
    let (linear_mps, angular_rps) = (cdr.array()?, cdr.array()?);
    Ok(Content::Twist(Twist { frame_id, linear_mps, angular_rps }))
}

/// `nav_msgs/Odometry` up to its twist: the child frame, in which that is, and the pose with its covariance.
fn odometry_frame<'a>(cdr: &mut Cdr<'a>) -> Result<&'a str, CdrError> {
    let child_frame_id = cdr.text()?;
    let _pose: [f64; 7] = cdr.array()?;
    let _covariance: [f64; 36] = cdr.array()?;
    Ok(child_frame_id)
}

/// `tf2_msgs/TFMessage`: as many `geometry_msgs/TransformStamped` as stands before them.
fn transforms(
    cdr: &mut Cdr<'_>,
    of_schema: &impl Fn(CdrError) -> MessageError,
) -> Result<Content, MessageError> {
    let count = cdr.u32().map_err(of_schema)?;
    if count as usize > MOST_FRAMES {
        return Err(MessageError::Transforms { count });
    }
    let mut transforms = Vec::new();
    for _ in 0..count {
        let (parent, child, parent_from_child) = transform(cdr).map_err(of_schema)?;
        let (parent, child) = (bounded(parent)?, bounded(child)?);
        transforms.push(StaticTransform { parent, child, parent_from_child });
    }
    Ok(Content::Transforms(transforms))
}

/// `geometry_msgs/TransformStamped`: parent, child and rotation.
fn transform<'a>(cdr: &mut Cdr<'a>) -> Result<(&'a str, &'a str, [f64; 4]), CdrError> {
    let (parent, child) = (header(cdr)?.frame_id, cdr.text()?);
    let _translation: [f64; 3] = cdr.array()?;
    Ok((parent, child, cdr.array()?))
}
