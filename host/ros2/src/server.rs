//! A service under any [`Mapping`].
//!
//! `ros2-client` only carries the bytes here (its enhanced mapping has no header). The headers of the other two mappings are part of the
//! messages instead, so that what follows them is aligned as CDR asks.

use std::io;

use ros2_client::dds::rustdds::mio1::{Interest, Registry, Token};
use ros2_client::{
    CreateError, Message, Name, Node, ReadError, RmwRequestId, ServiceMapping, ServiceTypeName, WriteError,
};
use serde::{Deserialize, Serialize};

use crate::options::{Mapping, Qos};

/// Who asked, as DDS-RPC says it: the writer, and the number of its sample.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
struct Identity {
    writer: [u8; 16],
    sequence_high: i32,
    sequence_low: u32,
}

#[derive(Clone, Debug, Serialize, Deserialize)]
struct BasicRequest<Q> {
    identity: Identity,
    instance: String,
    request: Q,
}

#[derive(Clone, Debug, Serialize, Deserialize)]
struct BasicReply<R> {
    identity: Identity,
    /// 0: nothing went wrong on the way.
    exception: i32,
    reply: R,
}

/// Cyclone's header: half the writer and the number of its sample; given back as it came.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Cyclone<X> {
    identity: [u8; 16],
    what: X,
}

impl<Q: Message> Message for BasicRequest<Q> {}
impl<R: Message> Message for BasicReply<R> {}
impl<X: Message> Message for Cyclone<X> {}

/// Whom an answer is for.
#[derive(Clone, Copy, Debug)]
pub struct Asker {
    id: RmwRequestId,
    identity: Identity,
    cyclone: [u8; 16],
}

enum Inner<Q: Message, R: Message> {
    Basic(ros2_client::Server<BasicRequest<Q>, BasicReply<R>>),
    Enhanced(ros2_client::Server<Q, R>),
    Cyclone(ros2_client::Server<Cyclone<Q>, Cyclone<R>>),
}

/// Takes requests `Q`, gives answers `R`.
pub struct Server<Q: Message, R: Message>(Inner<Q, R>);

impl<Q: Message + Clone + 'static, R: Message + Clone + 'static> Server<Q, R> {
    /// Offers a service.
    pub fn new(node: &mut Node, mapping: Mapping, name: &Name, of: &ServiceTypeName) -> Result<Self, CreateError> {
        let qos = Qos::usual;
        let plain = ServiceMapping::Enhanced;
        Ok(Self(match mapping {
            Mapping::Basic => Inner::Basic(node.create_server(plain, name, of, qos(), qos())?),
            Mapping::Enhanced => Inner::Enhanced(node.create_server(plain, name, of, qos(), qos())?),
            Mapping::Cyclone => Inner::Cyclone(node.create_server(plain, name, of, qos(), qos())?),
        }))
    }

    /// The next request, if there is one.
    pub fn receive(&self) -> Result<Option<(Asker, Q)>, ReadError> {
        let asker = |id| Asker { id, identity: Identity::default(), cyclone: [0; 16] };
        Ok(match &self.0 {
            Inner::Basic(server) => server
                .receive_request()?
                .map(|(id, asked)| (Asker { identity: asked.identity, ..asker(id) }, asked.request)),
            Inner::Enhanced(server) => server.receive_request()?.map(|(id, request)| (asker(id), request)),
            Inner::Cyclone(server) => server
                .receive_request()?
                .map(|(id, asked)| (Asker { cyclone: asked.identity, ..asker(id) }, asked.what)),
        })
    }

    /// Answers.
    pub fn respond(&self, asker: &Asker, reply: R) -> Result<(), WriteError<()>> {
        match &self.0 {
            Inner::Basic(server) => {
                server.send_response(asker.id, BasicReply { identity: asker.identity, exception: 0, reply })
            }
            Inner::Enhanced(server) => server.send_response(asker.id, reply),
            Inner::Cyclone(server) => server.send_response(asker.id, Cyclone { identity: asker.cyclone, what: reply }),
        }
    }

    /// Wakes whoever polls when a request comes.
    pub fn register(&mut self, registry: &Registry, token: Token) -> io::Result<()> {
        match &mut self.0 {
            Inner::Basic(server) => registry.register(server, token, Interest::READABLE),
            Inner::Enhanced(server) => registry.register(server, token, Interest::READABLE),
            Inner::Cyclone(server) => registry.register(server, token, Interest::READABLE),
        }
    }
}
