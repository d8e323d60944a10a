//! What the environment sets for all commands, where the command line does not.

/// Where the usual gripper is.
pub const LINK: &str = "FRE_LINK";
/// Where the usual bus of servos is.
pub const BUS: &str = "FRE_BUS";
/// Which debug probe is used, if there are several.
#[cfg(feature = "probe")]
pub const PROBE: &str = "FRE_PROBE";

/// A variable's value; an empty one is none.
pub fn value(name: &str) -> Option<String> {
    std::env::var(name).ok().filter(|words| !words.is_empty())
}

/// The command line's value, or else the environment's.
///
/// # Errors
/// What the environment has is not such a value.
pub fn or_else<T>(named: Option<&T>, name: &str) -> Result<Option<T>, String>
where
    T: std::str::FromStr<Err: std::fmt::Display> + Clone,
{
    match (named, value(name)) {
        (Some(named), _) => Ok(Some(named.clone())),
        (None, Some(words)) => words.parse().map(Some).map_err(|error| format!("{name} in the environment: {error}")),
        (None, None) => Ok(None),
    }
}
