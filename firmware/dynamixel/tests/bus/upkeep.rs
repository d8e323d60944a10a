//! Instructions that change what a device is, or when it does what it was asked for.

use dynamixel::{Backup, BulkAnswer, BulkWrite, Error, Id, ResetScope, StatusError, examples, xm430};

use crate::world::Bus;
use crate::{id, master, plain};

#[test]
fn instructions_of_upkeep() {
    let bus = Bus::new(&[1, 2]);
    let mut master = master(&bus);
    bus.run(async {
        assert_eq!(master.reg_write(id(1), 116, &512u32.to_le_bytes()).await, Ok(plain(())));
        assert_eq!(master.get(id(1), xm430::GOAL_POSITION).await, Ok(plain(0)));
        assert_eq!(master.get(id(1), xm430::REGISTERED_INSTRUCTION).await, Ok(plain(1)));
        assert_eq!(master.action(id(1)).await, Ok(plain(())));
        assert_eq!(master.get(id(1), xm430::GOAL_POSITION).await, Ok(plain(512)));
        let empty = Error::Refused { id: id(1), error: StatusError::Instruction, alert: false };
        assert_eq!(master.action(id(1)).await, Err(empty));
        assert_eq!(master.clear_turns(id(2)).await, Ok(plain(())));
        assert_eq!(master.factory_reset(id(2), ResetScope::All).await, Ok(plain(())));
        assert_eq!(master.factory_reset(Id::BROADCAST, ResetScope::ExceptId).await, Ok(plain(())));
        assert_eq!(master.factory_reset(Id::BROADCAST, ResetScope::All).await, Err(Error::Broadcast));
        assert_eq!(master.backup(id(1), Backup::Store).await, Ok(plain(())));
        assert_eq!(master.backup(id(1), Backup::Restore).await, Ok(plain(())));
        assert_eq!(master.set(id(1), xm430::TORQUE_ENABLE, 1).await, Ok(plain(())));
        let turning = Error::Refused { id: id(1), error: StatusError::ResultFail, alert: false };
        assert_eq!(master.backup(id(1), Backup::Store).await, Err(turning));
    });
    assert_eq!(bus.servo(0, |servo| servo.backups.clone()), [Backup::Store, Backup::Restore]);
    assert_eq!(
        bus.servo(1, |servo| (servo.clears, servo.resets.clone())),
        (1, vec![ResetScope::All, ResetScope::ExceptId])
    );
}

/// What the master sends is what the e-Manual publishes for it.
#[test]
fn instructions_are_the_published_ones() {
    let bus = Bus::new(&[1, 2]);
    let mut master = master(&bus);
    bus.run(async {
        master.reg_write(id(1), 104, &200u32.to_le_bytes()).await.unwrap();
        master.action(id(1)).await.unwrap();
        master.factory_reset(id(1), ResetScope::ExceptId).await.unwrap();
        master.reboot(id(1)).await.unwrap();
        master.clear_turns(id(1)).await.unwrap();
        master.backup(id(1), Backup::Store).await.unwrap();
        let (mut voltage, mut temperature) = ([0; 2], [0; 1]);
        let mut devices = [BulkAnswer::new(id(1), 144, &mut voltage), BulkAnswer::new(id(2), 146, &mut temperature)];
        master.bulk_read(&mut devices).await.unwrap();
        let writes = [
            BulkWrite { id: id(1), address: 32, bytes: &[160, 0] },
            BulkWrite { id: id(2), address: 31, bytes: &[80] },
        ];
        master.bulk_write(&writes).await.unwrap();
    });
    let names = [
        "reg write of goal velocity, 200",
        "action",
        "factory reset except id",
        "reboot",
        "clear of the turns",
        "control table backup: store",
        "bulk read of voltage and temperature",
        "bulk write of voltage and temperature limits",
    ];
    let published = names.map(|name| examples::EXAMPLES.into_iter().find(|it| it.name == name).unwrap());
    assert_eq!(bus.0.borrow().sent, published.map(|example| example.bytes.to_vec()));
}
