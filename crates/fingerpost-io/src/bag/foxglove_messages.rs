//! Foxglove's messages in protobuf.

use fingerpost_format::CameraInfo;
use foxglove::Decode;
use foxglove::messages::{CameraCalibration, CompressedImage, LocationFix, RawImage};

use super::message::{Content, GpsPosition, Message, MessageError};
use super::picture::{Picture, PixelLayout};
use super::schema::Schema;

/// The values of a message in protobuf.
pub(crate) fn decode(schema: Schema, data: &[u8]) -> Result<Message, MessageError> {
    let (timestamp, content) = match schema {
        Schema::FoxgloveRawImage => {
            let RawImage { timestamp, width, height, encoding, step, data, .. } = of_schema(schema, data)?;
            let [width, height, step] = [width, height, step].map(|length| length as usize);
            let layout = PixelLayout { width, height, step, encoding: &encoding };
            (timestamp, Content::Picture(Picture::raw(&layout, &data)?))
        }
        Schema::FoxgloveCameraCalibration => {
            let calibration: CameraCalibration = of_schema(schema, data)?;
            (calibration.timestamp, Content::Calibration(camera_info(calibration)))
        }
        Schema::FoxgloveLocationFix => {
            let LocationFix { timestamp, latitude, longitude, .. } = of_schema(schema, data)?;
            let position = GpsPosition { lat_deg: latitude, lon_deg: longitude };
            (timestamp, Content::Gps(Some(position)))
        }
        _ => {
            let CompressedImage { timestamp, data, format, .. } = of_schema(schema, data)?;
            (timestamp, Content::Picture(Picture::packed(&format, &data)?))
        }
    };
    Ok(Message { stamp_ns: timestamp.map(|stamp| stamp.total_nanos()).filter(|ns| *ns > 0), content })
}

fn of_schema<M: Decode>(schema: Schema, data: &[u8]) -> Result<M, MessageError> {
    M::decode(data).map_err(|cause| MessageError::Protobuf { name: schema.name(), cause: cause.to_string() })
}

/// A matrix that is missing becomes one of zeros, which no camera has and which is refused where a camera is made of it.
fn camera_info(calibration: CameraCalibration) -> CameraInfo {
    let CameraCalibration { width, height, distortion_model, d, k, p, .. } = calibration;
    CameraInfo {
        width: width as usize,
        height: height as usize,
        distortion_model,
        distortion: d,
        matrix: k.try_into().unwrap_or_default(),
        projection: p.try_into().unwrap_or_default(),
    }
}
