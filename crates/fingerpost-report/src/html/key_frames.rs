//! The key frames with every stage's picture.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use maud::{Markup, html};

use super::ReportInput;
use super::chart::number;
use crate::key_frames::{KeyFrame, KeyPicture, KeyReason};

/// The key frames in the order of the run; frames in which nothing was followed apart, where others tell more.
pub(crate) fn key_frames(input: &ReportInput<'_>) -> Markup {
    let frames = input.key_frames.frames();
    let losses = frames.iter().filter(|key| matches!(key.reason, KeyReason::Loss { .. })).count();
    let losses_not_shown = input.timeline.losses.count.saturating_sub(losses);
    let left_out = input.key_frames.features_left_out();
    let (spread, telling): (Vec<&KeyFrame>, Vec<&KeyFrame>) =
        frames.into_iter().partition(|key| key.reason == KeyReason::Spread);
    let anything = telling.iter().any(|key| key.reason != KeyReason::FirstFrame);
    html! {
        @for key in &telling { (key_frame(key)) }
        @if losses_not_shown > 0 {
            p { (losses_not_shown) " more losses are not shown." }
        }
        @if left_out > 0 {
            p { "The features with the strongest matches (" (left_out) ") are not shown." }
        }
        @if !spread.is_empty() && anything {
            details {
                summary { "Frames in which nothing was followed (" (spread.len()) ")" }
                @for key in &spread { (key_frame(key)) }
            }
        } @else {
            @for key in &spread { (key_frame(key)) }
        }
    }
}

fn key_frame(key: &KeyFrame) -> Markup {
    let reason = match key.reason {
        KeyReason::Detection { .. } => "Detection",
        KeyReason::Arrival { .. } => "Arrival",
        KeyReason::Loss { .. } => "Loss",
        KeyReason::WeakestMatch { .. } => "Weakest match",
        KeyReason::FirstFrame => "First frame",
        KeyReason::Spread => "On the way",
    };
    html! {
        article class="keyframe" {
            h3 {
                (reason)
                @if !key.feature.is_empty() { ": " (key.feature) }
                small { "frame " (key.frame) ", " (number(key.t_s)) " s" }
            }
            p class="why" { (key.why) }
            div class="picture" { @for picture in key.pictures.iter().take(1) { (shown(picture)) } }
            details {
                summary { "Every stage's picture" }
                div class="stages" {
                    @for picture in key.pictures.iter().skip(1) {
                        figure {
                            (shown(picture))
                            figcaption { b { (picture.stage) } " " (picture.legend) }
                        }
                    }
                }
            }
        }
    }
}

fn shown(picture: &KeyPicture) -> Markup {
    let (width, height) = picture.size_px;
    html! {
        img width=(width) height=(height) alt={ (picture.stage) ": " (picture.legend) }
            src={ "data:image/jpeg;base64," (STANDARD.encode(&picture.jpeg)) };
    }
}
