//! Pictures and pages made of evidence: what the method saw in a frame and why it decided.
//!
//! [`compose`] draws one annotated picture of a frame, [`StagePictures`] one picture a stage, [`KeyFrames`] keeps those
//! of the frames that a person wants to see afterwards, and [`report_html`] makes one self-contained page of a whole
//! run, [`front_html`] one of a search of settings, [`locating_html`] one of where a vehicle was found on the map, [`road_sheet`] shows what road detectors make of pictures, [`surface_svg`] a table of percentages, [`interval_svg`] figures over settings, [`plan_view_svg`] a closed-loop drive from above, [`closed_loop_html`] a table of many. Nothing here decides anything, touches a file or reads a clock: pictures come as [`RgbImage`], pages as text.
//!
//! [`RgbImage`]: fingerpost_vision::picture::RgbImage

mod closed_loop;
mod draw;
mod fix_track;
mod front;
mod html;
mod interval_plot;
mod key_frames;
mod locating;
mod palette;
mod panel;
mod plan_view;
mod road_sheet;
mod scene;
mod series;
mod surface_plot;
mod timeline;

pub use closed_loop::{ClosedLoopInput, closed_loop_html};
pub use front::{FrontInput, front_html};
pub use html::{ReportInput, Thresholds, report_html};
pub use interval_plot::{IntervalPlot, IntervalPoint, IntervalSeries, interval_svg};
pub use key_frames::{ChosenFrame, DrawnFrame, KeyFrame, KeyFrameChoice, KeyFrames, KeyPicture, KeyReason};
pub use locating::{LocatedDrive, LocatingInput, locating_html};
pub use palette::{NETWORK_CLASSES, NetworkClass, Rgb, road_colour, sub_mask as sub_mask_colour};
pub use panel::{
    COMPOSED_HEIGHT_PX, COMPOSED_WIDTH_PX, StagePicture, StagePictures, compose, network_picture,
};
pub use plan_view::{PlanView, plan_view_svg};
pub use road_sheet::{RoadSheetCell, RoadSheetRow, road_sheet};
pub use scene::{Scene, Setting};
pub use surface_plot::{SurfacePlot, is_surface_svg, surface_svg};
pub use timeline::Timeline;

use fingerpost_vision::jpeg::JpegError;
use thiserror::Error;

/// A picture that cannot be put into a report.
#[derive(Debug, Error)]
pub enum ReportError {
    /// The picture has no pixels or too many for a JPEG.
    #[error("the {stage} picture cannot be stored in the report ({cause}); check the picture's size")]
    Encode {
        /// Stage that the picture shows.
        stage: &'static str,
        /// What the encoder says.
        cause: JpegError,
    },
}
