//! Where the vehicle was on the map: its fixes on the roads, and their protection levels over time.

use maud::{Markup, html};

use super::ReportInput;

/// Map and chart, where the vehicle was located.
pub(crate) fn fixes(input: &ReportInput<'_>) -> Option<Markup> {
    let timeline = input.timeline;
    let (plane, fixes) = timeline.fixes.as_ref()?;
    let seconds = timeline.seconds.as_ref()?;
    Some(html! {
        @if let Some(graph) = input.roads {
            (fixes.moved(|place_m| graph.plane().map_from_wgs84(plane.wgs84_from_map(place_m))).map(graph))
        } @else {
            (fixes.legend())
        }
        (fixes.level_chart(seconds).figure())
    })
}
