//! ROS 2 messages in CDR. Source: the `.msg` files of ROS 2 `common_interfaces`, whose fields stand here in their order.

use fingerpost_format::CameraInfo;

use super::cdr::{Cdr, CdrError};
use super::message::{Content, GpsPosition, Message, MessageError, Twist};
use super::picture::{Picture, PixelLayout};
use super::schema::Schema;

/// Nanoseconds in a second.
const SECOND_NS: u64 = 1_000_000_000;

/// The values of a message in CDR.
pub(crate) fn decode(schema: Schema, data: &[u8]) -> Result<Message, MessageError> {
    let of_schema = |cause| MessageError::Cdr { name: schema.name(), cause };
    let mut cdr = Cdr::new(data).map_err(of_schema)?;
    // Twist alone has no header.
    let stamp_ns = match schema {
        Schema::RosTwist => None,
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
        Schema::RosImu => imu(&mut cdr).map_err(of_schema)?,
        Schema::RosOdometry => odometry(&mut cdr).map_err(of_schema)?,
        _ => twist(&mut cdr).map_err(of_schema)?,
    };
    Ok(Message { stamp_ns, content })
}

/// `std_msgs/Header`: stamp and frame. A stamp of zero is none.
fn header(cdr: &mut Cdr<'_>) -> Result<Option<u64>, CdrError> {
    let (seconds, nanoseconds) = (cdr.i32()?, cdr.u32()?);
    cdr.text()?;
    let seconds = u64::try_from(seconds).unwrap_or_default();
    let stamp_ns = seconds.saturating_mul(SECOND_NS).saturating_add(u64::from(nanoseconds));
    Ok((stamp_ns > 0).then_some(stamp_ns))
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

fn imu(cdr: &mut Cdr<'_>) -> Result<Content, CdrError> {
    let _orientation: [f64; 4] = cdr.array()?;
    let _orientation_covariance: [f64; 9] = cdr.array()?;
    let [_, _, yaw_rate_rps] = cdr.array()?;
    let [first_covariance, ..]: [f64; 9] = cdr.array()?;
    // A first element of -1 says that there is no such measurement.
    Ok(Content::YawRate((first_covariance >= 0.0).then_some(yaw_rate_rps)))
}

/// `geometry_msgs/Twist`: linear, angular. What may follow is its covariance.
fn twist(cdr: &mut Cdr<'_>) -> Result<Content, CdrError> {
    let [speed_mps, _, _, _, _, yaw_rate_rps] = cdr.array()?;
    Ok(Content::Twist(Twist { speed_mps, yaw_rate_rps }))
}

/// `nav_msgs/Odometry`: the child frame, in which the twist is, and the pose with its covariance come before it.
fn odometry(cdr: &mut Cdr<'_>) -> Result<Content, CdrError> {
    cdr.text()?;
    let _pose: [f64; 7] = cdr.array()?;
    let _covariance: [f64; 36] = cdr.array()?;
    twist(cdr)
}
