//! `docs/messages.md`: what a gripper and its host say to each other, from the messages' own definitions.

use std::collections::BTreeSet;
use std::fmt::Write as _;

use messages::*;
use postcard_rpc::{Endpoint, Topic};
use postcard_schema::Schema;
use postcard_schema::schema::{DataModelType, DataModelVariant, NamedType};

/// Paths that postcard-rpc adds to every list of its own.
const STANDARD: &str = "postcard-rpc/";

const INTRODUCTION: &str = "\
<!-- Made by `cargo xtask docs` from firmware/messages; a test keeps it current. -->

# Messages

What a gripper and its host say to each other, over USB, a serial port or a socket. `fre`, the live page and the Python package speak it for
you; this page is for programs of your own. The crate `messages` (`firmware/messages`, `no_std`) has all definitions in Rust.

A message is a header (key and sequence number) and the [postcard](https://docs.rs/postcard) encoding of its type, as
[postcard-rpc](https://docs.rs/postcard-rpc) defines it. It is sent as one frame: COBS between zero bytes, with a CRC-32. The key is a
hash of path and type, so programs with different definitions do not misread each other: the gripper refuses such a request as unknown, and a
host ignores such a topic. postcard-rpc's own requests, `postcard-rpc/ping` and `postcard-rpc/schemas/get`, are answered as well.

Units: mm, N, N·mm, rad, µs, unless a field's name says otherwise.
";

/// Path, request and response of an endpoint.
fn endpoint<E: Endpoint>() -> (&'static str, [&'static NamedType; 2]) {
    (E::PATH, [E::Request::SCHEMA, E::Response::SCHEMA])
}

/// Path and message of a topic.
fn topic<T: Topic>() -> (&'static str, [&'static NamedType; 1])
where
    T::Message: Schema,
{
    (T::PATH, [T::Message::SCHEMA])
}

/// Types that are written where they are used, because they hold another type each time.
const WRITTEN: [&str; 2] = ["For", "Result<T, E>"];

/// Whether a type is shown in a section of its own.
fn is_listed(ty: &NamedType) -> bool {
    !WRITTEN.contains(&ty.name)
        && matches!(ty.ty, DataModelType::Struct(_) | DataModelType::Enum(_) | DataModelType::TupleStruct(_))
}

/// A type as it is written where it is used.
fn written(ty: &NamedType) -> String {
    let list = |types: &[&NamedType]| types.iter().map(|ty| written(ty)).collect::<Vec<_>>().join(", ");
    match ty.ty {
        DataModelType::Bool => "bool".to_owned(),
        DataModelType::Unit | DataModelType::UnitStruct => "nothing".to_owned(),
        DataModelType::String => "text".to_owned(),
        DataModelType::ByteArray => "bytes".to_owned(),
        DataModelType::Option(inner) => format!("optional {}", written(inner)),
        DataModelType::Seq(inner) => format!("list of {}", written(inner)),
        DataModelType::NewtypeStruct(inner) => written(inner),
        DataModelType::Tuple(types) => match types {
            [first, ..] if types.iter().all(|ty| ty == first) => format!("{} × {}", types.len(), written(first)),
            _ => format!("({})", list(types)),
        },
        DataModelType::Enum(variants) if ty.name == WRITTEN[1] => {
            let results = variants.iter().map(|variant| match variant.ty {
                DataModelVariant::NewtypeVariant(inner) | DataModelVariant::TupleVariant([inner]) => {
                    format!("`{}`: {}", variant.name, written(inner))
                }
                other => panic!("a result holds a value: {other:?}"),
            });
            results.collect::<Vec<_>>().join(", or ")
        }
        DataModelType::Struct(fields) if ty.name == WRITTEN[0] => {
            let [finger, value] = fields else { panic!("For has a finger and a value: {fields:?}") };
            format!("{} {}, {} {}", finger.name, written(finger.ty), value.name, written(value.ty))
        }
        _ if is_listed(ty) => format!("[{0}](#{1})", ty.name, ty.name.to_lowercase()),
        _ => ty.name.to_owned(),
    }
}

/// The types that a type holds.
fn parts(ty: &NamedType) -> Vec<&'static NamedType> {
    match ty.ty {
        DataModelType::Option(inner) | DataModelType::Seq(inner) | DataModelType::NewtypeStruct(inner) => vec![inner],
        DataModelType::Tuple(types) | DataModelType::TupleStruct(types) => types.to_vec(),
        DataModelType::Struct(fields) => fields.iter().map(|field| field.ty).collect(),
        DataModelType::Enum(variants) => variants
            .iter()
            .flat_map(|variant| match variant.ty {
                DataModelVariant::UnitVariant => vec![],
                DataModelVariant::NewtypeVariant(inner) => vec![*inner],
                DataModelVariant::TupleVariant(types) => types.to_vec(),
                DataModelVariant::StructVariant(fields) => fields.iter().map(|field| field.ty).collect(),
            })
            .collect(),
        _ => vec![],
    }
}

/// Collects the types that have a section, in the order in which a reader meets them.
fn collect(ty: &'static NamedType, listed: &mut Vec<&'static NamedType>) {
    if is_listed(ty) {
        if listed.contains(&ty) {
            return;
        }
        assert!(!listed.iter().any(|other| other.name == ty.name), "two types are called {}", ty.name);
        listed.push(ty);
    }
    for part in parts(ty) {
        collect(part, listed);
    }
}

fn section(out: &mut String, ty: &NamedType) {
    let _ = write!(out, "\n### {}\n\n", ty.name);
    match ty.ty {
        DataModelType::Struct(fields) => {
            out.push_str("| field | type |\n|---|---|\n");
            for field in *fields {
                let _ = writeln!(out, "| `{}` | {} |", field.name, written(field.ty));
            }
        }
        DataModelType::TupleStruct(types) => {
            let types: Vec<String> = types.iter().map(|ty| written(ty)).collect();
            let _ = writeln!(out, "{}", types.join(", "));
        }
        DataModelType::Enum(variants) => {
            out.push_str("One of these, by its number:\n\n| | variant | with |\n|---:|---|---|\n");
            for (number, variant) in variants.iter().enumerate() {
                let with = match variant.ty {
                    DataModelVariant::UnitVariant => String::new(),
                    DataModelVariant::NewtypeVariant(inner) => written(inner),
                    DataModelVariant::TupleVariant(types) => {
                        types.iter().map(|ty| written(ty)).collect::<Vec<_>>().join(", ")
                    }
                    DataModelVariant::StructVariant(fields) => {
                        let field = |field: &&postcard_schema::schema::NamedValue| {
                            format!("`{}` {}", field.name, written(field.ty))
                        };
                        fields.iter().map(field).collect::<Vec<_>>().join(", ")
                    }
                };
                let _ = writeln!(out, "| {number} | `{}` | {with} |", variant.name);
            }
        }
        other => panic!("{other:?} has no section"),
    }
}

#[test]
fn the_page_of_messages_is_what_the_definitions_say() {
    let requests = [
        endpoint::<GetVersion>(),
        endpoint::<GetBoot>(),
        endpoint::<GetObject>(),
        endpoint::<SetObject>(),
        endpoint::<PlaceObject>(),
        endpoint::<GetFinger>(),
        endpoint::<SetFinger>(),
        endpoint::<GetUncertainty>(),
        endpoint::<SetUncertainty>(),
        endpoint::<GetSettings>(),
        endpoint::<GetServo>(),
        endpoint::<SetSettings>(),
        endpoint::<Open>(),
        endpoint::<Close>(),
        endpoint::<Grip>(),
        endpoint::<Carry>(),
        endpoint::<Hold>(),
        endpoint::<Relax>(),
        endpoint::<Scan>(),
        endpoint::<GetCounters>(),
        endpoint::<Provoke>(),
    ];
    let topics = [topic::<EstimateTopic>(), topic::<GraspTopic>(), topic::<ShapeTopic>(), topic::<EventTopic>()];
    assert_eq!(
        requests.iter().map(|(path, _)| *path).collect::<BTreeSet<_>>(),
        ENDPOINTS.endpoints.iter().map(|(path, ..)| *path).filter(|path| !path.starts_with(STANDARD)).collect(),
        "a request is missing in this test"
    );
    assert_eq!(
        topics.iter().map(|(path, _)| *path).collect::<BTreeSet<_>>(),
        TOPICS_OUT.topics.iter().map(|(path, _)| *path).filter(|path| !path.starts_with(STANDARD)).collect(),
        "a topic is missing in this test"
    );

    let mut page = String::from(INTRODUCTION);
    let _ = write!(page, "\nVersion of the protocol: {PROTOCOL_VERSION}. A gripper has at most {FINGERS} fingers.\n\n");
    page.push_str(
        "## Requests\n\nThe host asks, the gripper answers once.\n\n| path | request | answer |\n|---|---|---|\n",
    );
    let mut listed = Vec::new();
    for (path, types) in &requests {
        let _ = writeln!(page, "| `{path}` | {} | {} |", written(types[0]), written(types[1]));
        types.iter().for_each(|ty| collect(ty, &mut listed));
    }
    page.push_str("\n## Topics\n\nThe gripper sends these without being asked.\n\n| path | message |\n|---|---|\n");
    for (path, types) in &topics {
        let _ = writeln!(page, "| `{path}` | {} |", written(types[0]));
        types.iter().for_each(|ty| collect(ty, &mut listed));
    }
    page.push_str("\n## Types\n");
    listed.sort_by_key(|ty| ty.name);
    listed.iter().for_each(|ty| section(&mut page, ty));
    book::generated::hold("docs/messages.md", page.as_bytes());
}
