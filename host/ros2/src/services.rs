//! What can be asked of the node: grip, release, stop, relax, and its parameters. In a thread of its own.

use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::Duration;

use fre_gripper::source::{Order, OrderError, Setup, Source};
use ros2_client::dds::rustdds::mio1::{Events, Poll, Token};
use ros2_client::parameters::{Parameter, raw};
use ros2_client::rcl_interfaces::{
    DescribeParametersRequest, DescribeParametersResponse, GetParameterTypesRequest, GetParameterTypesResponse,
    GetParametersRequest, GetParametersResponse, ListParametersRequest, ListParametersResponse,
    SetParametersAtomicallyResponse, SetParametersRequest, SetParametersResponse,
};
use ros2_client::{CreateError, Message, Name, Node, ServiceTypeName};

use crate::message::{TriggerRequest, TriggerResponse};
use crate::options::Mapping;
use crate::parameters::Parameters;
use crate::server::Server;

impl Message for TriggerRequest {}
impl Message for TriggerResponse {}

/// How often is looked whether the services are still wanted.
const GLANCE: Duration = Duration::from_millis(50);

/// Who does what is asked: the source, or nobody for a recording.
pub type Leader = Option<Arc<dyn Source>>;

type Trigger = Server<TriggerRequest, TriggerResponse>;

/// The services of a node.
pub struct Services {
    stop: Trigger,
    release: Trigger,
    grip: Trigger,
    relax: Trigger,
    get: Server<GetParametersRequest, GetParametersResponse>,
    types: Server<GetParameterTypesRequest, GetParameterTypesResponse>,
    set: Server<SetParametersRequest, SetParametersResponse>,
    set_at_once: Server<SetParametersRequest, SetParametersAtomicallyResponse>,
    list: Server<ListParametersRequest, ListParametersResponse>,
    describe: Server<DescribeParametersRequest, DescribeParametersResponse>,
    answering: Answering,
}

/// What answers depend on.
struct Answering {
    parameters: Parameters,
    leader: Leader,
}

/// Services that are answered until this is dropped.
pub struct Running {
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Drop for Running {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Release);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

impl Services {
    /// Offers them below the node's name.
    pub fn new(node: &mut Node, mapping: Mapping, setup: &Setup, leader: Leader) -> Result<Self, CreateError> {
        let own = node.fully_qualified_name();
        let name =
            |service| Name::new(&own, service).map_err(|error| CreateError::BadParameter { reason: error.to_string() });
        let trigger = ServiceTypeName::new("std_srvs", "Trigger");
        let of = |kind| ServiceTypeName::new("rcl_interfaces", kind);
        Ok(Self {
            stop: Server::new(node, mapping, &name("stop")?, &trigger)?,
            release: Server::new(node, mapping, &name("release")?, &trigger)?,
            grip: Server::new(node, mapping, &name("grip")?, &trigger)?,
            relax: Server::new(node, mapping, &name("relax")?, &trigger)?,
            get: Server::new(node, mapping, &name("get_parameters")?, &of("GetParameters"))?,
            types: Server::new(node, mapping, &name("get_parameter_types")?, &of("GetParameterTypes"))?,
            set: Server::new(node, mapping, &name("set_parameters")?, &of("SetParameters"))?,
            set_at_once: {
                Server::new(node, mapping, &name("set_parameters_atomically")?, &of("SetParametersAtomically"))?
            },
            list: Server::new(node, mapping, &name("list_parameters")?, &of("ListParameters"))?,
            describe: Server::new(node, mapping, &name("describe_parameters")?, &of("DescribeParameters"))?,
            answering: Answering { parameters: Parameters::new(setup), leader },
        })
    }

    /// Answers from now on.
    ///
    /// # Errors
    /// The system has no more threads or files.
    pub fn start(mut self) -> io::Result<Running> {
        let poll = Poll::new()?;
        let registry = poll.registry();
        let mut tokens = (0..).map(Token);
        let mut token = || tokens.next().unwrap_or(Token(0));
        self.stop.register(registry, token())?;
        self.release.register(registry, token())?;
        self.grip.register(registry, token())?;
        self.relax.register(registry, token())?;
        self.get.register(registry, token())?;
        self.types.register(registry, token())?;
        self.set.register(registry, token())?;
        self.set_at_once.register(registry, token())?;
        self.list.register(registry, token())?;
        self.describe.register(registry, token())?;
        let stop = Arc::new(AtomicBool::new(false));
        let for_thread = stop.clone();
        let thread = std::thread::Builder::new().name("ros2-services".into());
        let thread = thread.spawn(move || self.answer_all(poll, &for_thread))?;
        Ok(Running { stop, thread: Some(thread) })
    }

    fn answer_all(mut self, mut poll: Poll, stop: &AtomicBool) {
        let mut events = Events::with_capacity(16);
        while !stop.load(Ordering::Acquire) {
            if let Err(error) = poll.poll(&mut events, Some(GLANCE))
                && error.kind() != io::ErrorKind::Interrupted
            {
                std::thread::sleep(GLANCE);
            }
            // All of them whichever woke us, whoever wants a stop first.
            self.answer();
        }
    }

    fn answer(&mut self) {
        let it = &mut self.answering;
        answer(&self.stop, |_| it.order("stopped", |parameters| Order::Hold(parameters.which())));
        answer(&self.relax, |_| it.order("without torque", |parameters| Order::Relax(parameters.which())));
        answer(&self.release, |_| it.order("opens", |parameters| Order::Open(parameters.which())));
        answer(&self.grip, |_| it.order("grips", |parameters| Order::Grip(parameters.grip())));
        answer(&self.get, |asked| {
            it.refresh();
            let value = |name: &String| it.parameters.get(name).into();
            GetParametersResponse { values: asked.names.iter().map(value).collect() }
        });
        answer(&self.types, |asked| {
            it.refresh();
            let kind = |name: &String| it.parameters.get(name).to_parameter_type() as u8;
            GetParameterTypesResponse { values: asked.names.iter().map(kind).collect() }
        });
        answer(&self.set, |asked| SetParametersResponse {
            results: asked.parameter.into_iter().map(|one| result(it.set(vec![one]))).collect(),
        });
        answer(&self.set_at_once, |asked| SetParametersAtomicallyResponse { result: result(it.set(asked.parameter)) });
        answer(&self.list, |asked| {
            it.refresh();
            ListParametersResponse { result: it.parameters.list(&asked.prefixes, asked.depth) }
        });
        answer(&self.describe, |asked| {
            it.refresh();
            let values = asked.names.iter().map(|name| it.parameters.describe(name)).collect();
            DescribeParametersResponse { values }
        });
    }
}

/// Answers every request that waits. One that cannot be read, or whose asker is gone, costs itself only.
fn answer<Q, R>(server: &Server<Q, R>, mut reply: impl FnMut(Q) -> R)
where
    Q: Message + Clone + 'static,
    R: Message + Clone + 'static,
{
    loop {
        match server.receive() {
            Ok(Some((asker, request))) => {
                let _ = server.respond(&asker, reply(request));
            }
            Ok(None) => return,
            Err(_) => {}
        }
    }
}

fn result(done: Result<(), String>) -> raw::SetParametersResult {
    raw::SetParametersResult { successful: done.is_ok(), reason: done.err().unwrap_or_default() }
}

impl Answering {
    /// Gives the source an order.
    fn order(&self, done: &str, order: impl Fn(&Parameters) -> Order) -> TriggerResponse {
        match self.lead(&order(&self.parameters)) {
            Ok(()) => TriggerResponse { success: true, message: done.to_owned() },
            Err(why) => TriggerResponse { success: false, message: why },
        }
    }

    fn lead(&self, order: &Order) -> Result<(), String> {
        let leader = self.leader.as_ref().ok_or("this is a recording: nothing of it can be changed")?;
        leader.order(order).map_err(|error: OrderError| error.to_string())
    }

    /// Others may have changed the settings.
    fn refresh(&mut self) {
        if let Some(Ok(setup)) = self.leader.as_ref().map(|leader| leader.setup()) {
            self.parameters.now(setup.settings);
        }
    }

    /// Changes all of these or none.
    fn set(&mut self, changes: Vec<raw::Parameter>) -> Result<(), String> {
        self.refresh();
        let mut changed = self.parameters.clone();
        for Parameter { name, value } in changes.into_iter().map(Parameter::from) {
            changed.set(&name, &value)?;
        }
        if changed.settings() != self.parameters.settings() {
            self.lead(&Order::Settings(*changed.settings()))?;
        }
        self.parameters = changed;
        Ok(())
    }
}
