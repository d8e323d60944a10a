//! The demonstration on the live page: the gripper in QEMU closes and opens until a person leads it.

use std::net::SocketAddr;
use std::path::Path;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::sync::mpsc::RecvTimeoutError;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use messages::Which;
use model_core::discretise::Physics;

use super::boot::boot;
use super::error::DemoError;
use super::lead::{Lead, Order};
use super::task::LOG;
use fre::files::Folder;
use fre_qemu::Pace;

use crate::link::{Link, Told};
use crate::web;

/// Ticks per shape: a smooth picture, at some cost of QEMU's time.
const SHAPE_EVERY: u16 = 25;
/// A closing and opening, s.
const ROUND: f64 = 12.0;
/// How often the lead looks where the finger is.
const GLANCE: Duration = Duration::from_millis(20);

/// Serves the live page until `stop` is set; `ready` gets its address. The firmware's log goes to `folder`.
///
/// # Errors
/// Whatever keeps the gripper or the page from working.
pub fn live(
    firmware: &Path,
    folder: &mut Folder,
    pace: Pace,
    physics: Physics,
    address: SocketAddr,
    stop: &AtomicBool,
    ready: impl FnOnce(&str),
) -> Result<(), DemoError> {
    let booted = boot(firmware, folder.stream(LOG)?, pace, physics, SHAPE_EVERY, stop)?;
    let (mut machine, link) = (booted.machine, Arc::new(booted.link));
    drop(booted.heard);
    let lead = Arc::new(web::Lead::default());
    let (goal, over) = (AtomicU32::new(f32::NAN.to_bits()), AtomicBool::new(false));
    let failed = Mutex::new(None);
    let served = std::thread::scope(|scope| {
        let (leads, link_too, goal, over, failed) = (lead.clone(), link.clone(), &goal, &over, &failed);
        scope.spawn(move || {
            if let Err(error) = keep_leading(&leads, &link_too, goal, over) {
                *failed.lock().unwrap_or_else(PoisonError::into_inner) = Some(error);
            }
        });
        let told = link.listen();
        scope.spawn(move || {
            while !over.load(Ordering::Relaxed) {
                match told.recv_timeout(GLANCE) {
                    Ok(Told::Report(report)) => goal.store(report.goal.to_bits(), Ordering::Relaxed),
                    Ok(_) | Err(RecvTimeoutError::Timeout) => {}
                    Err(RecvTimeoutError::Disconnected) => return,
                }
            }
        });
        let served = web::serve(link.clone(), address, Some(lead), None, stop, ready);
        over.store(true, Ordering::Relaxed);
        served
    });
    // QEMU's end shows in the link first.
    if !stop.load(Ordering::Relaxed) {
        std::thread::sleep(Duration::from_millis(200));
        machine.check()?;
    }
    served?;
    match failed.into_inner().unwrap_or_else(PoisonError::into_inner) {
        Some(error) if !stop.load(Ordering::Relaxed) => Err(DemoError::Link(error)),
        _ => Ok(()),
    }
}

/// Closes and opens, round after round; a person's order interrupts, and the page's button begins a new round.
fn keep_leading(
    lead: &web::Lead,
    link: &Link,
    goal: &AtomicU32,
    over: &AtomicBool,
) -> Result<(), crate::link::LinkError> {
    let mut round: Option<(Instant, Lead)> = None;
    while !over.load(Ordering::Relaxed) {
        std::thread::sleep(GLANCE);
        let goal_deg = f64::from(f32::from_bits(goal.load(Ordering::Relaxed))).to_degrees();
        if lead.is_pausing() || goal_deg.is_nan() {
            round = None;
            continue;
        }
        let (start, led) = round.get_or_insert_with(|| (Instant::now(), Lead::new(ROUND)));
        let now = start.elapsed().as_secs_f64();
        let mut outcome = Ok(());
        if let Some(Order { angle_deg, speed_deg }) = led.step(now, goal_deg) {
            let (angle, speed) = (angle_deg.to_radians() as f32, speed_deg.to_radians() as f32);
            lead.order(|| outcome = link.close(Which::All, angle, Some(speed)));
        } else if led.is_round() {
            round = None;
        }
        match outcome {
            // The target may be busy, or its servo away: the page shows it, and the next round tries again.
            Err(crate::link::LinkError::Refused(_) | crate::link::LinkError::Timeout { .. }) => round = None,
            other => other?,
        }
    }
    Ok(())
}
