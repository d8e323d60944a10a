//! One finger's state machines: everything that can be asked of them, with anything that can come.

use core::hint::black_box;

use grip::{
    Bounds, Budget, Calibration, Carry, Contact, Faults, Firmness, Gear, Grip, Health, Limits, Margins, Meter, Motor,
    Phase, Reaction, StrainWatch, Target, Touch, Vitals, Why,
};

/// A finger.
pub struct Finger {
    grip: Grip,
    contact: Contact,
    budget: Budget,
    health: Health,
    meter: Meter,
    strain: StrainWatch,
}

impl Finger {
    /// It has not moved.
    pub fn new() -> Self {
        Self {
            grip: Grip::REST,
            contact: Contact::NONE,
            budget: Budget::new(black_box(8)),
            health: Health::READY,
            meter: Meter::new(0),
            strain: StrainWatch::FREE,
        }
    }

    /// Everything once; in a function of its own, whose symbol shows that it is in the image.
    #[inline(never)]
    pub fn run(&mut self) {
        let limits = black_box(Limits { range: [0.0; 2], open_angle: 0.0, speed: 0.0, force: 0.0, current: 0.0 });
        self.order(&limits);
        self.derate();
        self.tick(&limits);
        self.watch();
    }

    fn order(&mut self, limits: &Limits) {
        let grip = &mut self.grip;
        grip.found(black_box(0.0));
        grip.renamed(black_box(0.0));
        grip.head(black_box(0.0), black_box(0.0));
        grip.grip(&black_box(Target::of(0.0)), limits);
        grip.hold();
        grip.open(limits);
        grip.leave(limits, black_box(Reaction::Release));
        grip.relax();
    }

    fn tick(&mut self, limits: &Limits) {
        let calibration = Calibration::new(&black_box(Gear::DIRECT));
        black_box(calibration.position(self.grip.advance(black_box(0.0), limits)));
        let touch = Touch {
            angle: calibration.finger_angle(black_box(0)),
            force: black_box(Some(0.0)),
            slope: black_box(Some(0.0)),
            has_model: black_box(true),
            current: black_box(0.0),
            firmness: black_box(Firmness::XM430),
            alert: black_box(false),
            part: self.strain.part(),
            stop: self.strain.stops(),
            relaxes: black_box(true),
        };
        let faults = black_box(Faults { reaction: Reaction::Hold, untrusted_s: 0.0, strain: Reaction::Hold });
        self.grip.feel(&touch, calibration.count(), black_box(0.0), limits, &faults);
        self.grip.miss(limits, faults.reaction);
        self.grip.restrict(limits);
        black_box((self.grip.phase().why().map(Why::words), Phase::word(self.grip.phase()), self.grip.is_gripping()));
    }

    fn derate(&mut self) {
        let vitals = black_box(Vitals { temperature: 0, voltage: 0 });
        let bounds = black_box(Bounds { temperature: 0, voltage: 0 });
        let margins = black_box(Margins { heat: 0.0, supply: 0.0 });
        black_box(self.strain.see(vitals, bounds, margins));
    }

    fn watch(&mut self) {
        let motor = black_box(Motor::XM430);
        let [angle, count] = black_box([0.0; 2]);
        black_box(self.contact.feel(&motor, angle, black_box(0.0), count, black_box(None), black_box(0.0)));
        let mut carry = Carry::new(black_box(0.0), black_box(0.0), black_box(0.0));
        black_box((carry.weigh(black_box(0.0)), carry.force(), carry.is_enough()));
        self.budget.spent(black_box(0), black_box(0));
        black_box((self.budget.iterations(black_box(0)), self.budget.most()));
        black_box(self.budget.allows_another(black_box(0), black_box(0), black_box(0)));
        self.health.answered();
        black_box(self.health.failed(black_box(0.0)));
        black_box(self.meter.tick(black_box(0), black_box(0.0)));
    }
}
