//! Reads the displacements in CalculiX's `.frd` file: fixed columns, three for the kind of line, ten for a node, twelve for each number.

use std::collections::{BTreeMap, HashMap};

use super::error::FeaError;
use super::region::Point;

/// Where a node's number ends, and how wide each value behind it is.
const NODE_END: usize = 13;
const VALUE: usize = 12;
/// Where a result block's time is.
const TIME: core::ops::Range<usize> = 12..24;

/// Displacements (mm) by node (from 1), by time: those at whole times only, as in [`super::ccx::parse_dat`]. A block that the file breaks off in
/// is left out.
///
/// # Errors
/// Naming the line that is not as expected.
pub fn parse_frd(text: &str) -> Result<BTreeMap<usize, HashMap<usize, Point>>, FeaError> {
    let mut found = BTreeMap::new();
    let mut step = None;
    let mut block: Option<HashMap<usize, Point>> = None;
    // What is left of a line at the end of a file that breaks off is none.
    let whole = text.rfind('\n').map_or("", |end| &text[..end]);
    for (index, line) in whole.lines().enumerate() {
        let bad = || FeaError::Output { file: "frd", line: index + 1, text: line.trim().to_owned() };
        let field = |from: usize, to: usize| line.get(from..to.min(line.len())).map(str::trim);
        match (line.get(..3), block.as_mut()) {
            (Some(" -1"), Some(nodes)) => {
                let node = field(3, NODE_END).and_then(|text| text.parse().ok()).ok_or_else(bad)?;
                let value = |i: usize| {
                    let from = NODE_END + i * VALUE;
                    field(from, from + VALUE).and_then(|text| text.parse::<f64>().ok()).ok_or_else(bad)
                };
                nodes.insert(node, [value(0)?, value(1)?]);
            }
            (Some(" -3"), Some(_)) => {
                if let (Some(step), Some(nodes)) = (step, block.take()) {
                    found.insert(step, nodes);
                }
            }
            (Some(" -4"), None) if field(3, 13).is_some_and(|name| name.starts_with("DISP")) && step.is_some() => {
                block = Some(HashMap::new());
            }
            _ if line.trim_start().starts_with("100C") => {
                let time: f64 = field(TIME.start, TIME.end).and_then(|text| text.parse().ok()).ok_or_else(bad)?;
                let whole = time.round();
                step = ((time - whole).abs() < 1e-6 && whole >= 1.0).then_some(whole as usize);
            }
            _ => {}
        }
    }
    Ok(found)
}
