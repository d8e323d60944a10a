//! Control tables of the models, as ROBOTIS' [e-Manual](https://emanual.robotis.com/docs/en/dxl/) lists them.
//!
//! Each is that of the XM430-W350 with its differences: registers that are missing, and registers of its own (others' places, factory
//! values or ranges). External ports are left out everywhere.

use crate::item::{Area, Item, Register};
use crate::models::{Layout, Model};
use crate::xm430;

use Area::{Eeprom, Ram};

/// How a table differs from the XM430-W350's.
struct Differences {
    /// Registers that it does not have, by the XM430's addresses.
    missing: &'static [u16],
    /// Registers of its own, instead of those at the same place.
    own: &'static [Item],
}

const fn byte(address: u16, area: Area, default: i64, min: i64, max: i64) -> Item {
    Register::<u8>::write(address, false, area, default, min, max).item
}

const fn word(address: u16, area: Area, default: i64, min: i64, max: i64) -> Item {
    Register::<u16>::write(address, false, area, default, min, max).item
}

const fn long(address: u16, area: Area, default: i64, min: i64, max: i64) -> Item {
    Register::<u32>::write(address, false, area, default, min, max).item
}

const fn signed_word(address: u16, max: i64) -> Item {
    Register::<i16>::write(address, true, Ram, 0, -max, max).item
}

const fn signed_long(address: u16, area: Area, default: i64, min: i64, max: i64) -> Item {
    Register::<i32>::write(address, true, area, default, min, max).item
}

static NONE: Differences = Differences { missing: &[], own: &[] };

static XL430: Differences = Differences {
    // Current Limit and Goal Current.
    missing: &[38, 102],
    own: &[
        byte(31, Eeprom, 72, 0, 100),
        word(32, Eeprom, 140, 60, 140),
        word(34, Eeprom, 60, 60, 140),
        long(44, Eeprom, 265, 0, 1023),
        word(76, Ram, 1000, 0, 16_383),
        word(80, Ram, 4000, 0, 16_383),
        word(84, Ram, 640, 0, 16_383),
        // Present Load.
        Register::<i16>::read(126, true, Ram, 0).item,
    ],
};

static XM540: Differences = Differences {
    missing: &[],
    own: &[word(38, Eeprom, 2047, 0, 2047), long(44, Eeprom, 128, 0, 1023), signed_word(102, 2047)],
};

static XL330: Differences = Differences {
    missing: &[],
    own: &[
        byte(8, Eeprom, 1, 0, 6),
        byte(13, Eeprom, 2, 2, 22),
        byte(31, Eeprom, 70, 0, 100),
        word(32, Eeprom, 70, 31, 70),
        word(34, Eeprom, 35, 31, 70),
        word(38, Eeprom, 1750, 0, 1750),
        long(44, Eeprom, 445, 0, 2047),
        // PWM Slope.
        byte(62, Eeprom, 140, 1, 255),
        byte(63, Eeprom, 53, 0, 63),
        word(76, Ram, 1600, 0, 16_383),
        word(78, Ram, 180, 0, 16_383),
        word(84, Ram, 400, 0, 16_383),
        signed_word(102, 1750),
        signed_long(104, Ram, 0, -2047, 2047),
    ],
};

static XC330: Differences = Differences {
    missing: &[],
    own: &[
        byte(8, Eeprom, 1, 0, 6),
        byte(13, Eeprom, 2, 2, 22),
        byte(31, Eeprom, 70, 0, 100),
        word(32, Eeprom, 140, 55, 140),
        word(34, Eeprom, 55, 55, 140),
        word(38, Eeprom, 910, 0, 910),
        long(44, Eeprom, 320, 0, 2047),
        // PWM Slope.
        byte(62, Eeprom, 255, 1, 255),
        word(76, Ram, 1200, 0, 16_383),
        word(78, Ram, 40, 0, 16_383),
        word(84, Ram, 900, 0, 16_383),
        signed_word(102, 910),
        signed_long(104, Ram, 0, -2047, 2047),
    ],
};

static PM42: Differences = Differences {
    // Startup Configuration and Backup Ready.
    missing: &[60, 147],
    own: &[
        byte(8, Eeprom, 1, 0, 9),
        byte(10, Eeprom, 0, 0, 1),
        byte(13, Eeprom, 2, 2, 10),
        signed_long(20, Eeprom, 0, i32::MIN as i64, i32::MAX as i64),
        long(24, Eeprom, 20, 0, 2600),
        word(32, Eeprom, 350, 150, 350),
        word(34, Eeprom, 150, 150, 350),
        word(36, Eeprom, 2009, 0, 2009),
        word(38, Eeprom, 1461, 0, 1461),
        // Acceleration Limit.
        long(40, Eeprom, 10_867, 0, 4_346_756),
        long(44, Eeprom, 2600, 0, 2600),
        signed_long(48, Eeprom, 262_931, -263_187, 263_187),
        signed_long(52, Eeprom, -262_931, -263_187, 263_187),
        byte(63, Eeprom, 58, 0, 255),
        // LED red, green and blue.
        byte(513, Ram, 0, 0, 255),
        byte(514, Ram, 0, 0, 255),
        byte(515, Ram, 0, 0, 255),
        // The manual gives no factory values of the gains.
        word(524, Ram, 0, 0, 32_767),
        word(526, Ram, 0, 0, 32_767),
        word(528, Ram, 0, 0, 32_767),
        word(530, Ram, 0, 0, 32_767),
        word(532, Ram, 0, 0, 32_767),
        word(536, Ram, 0, 0, 32_767),
        word(538, Ram, 0, 0, 32_767),
        signed_word(548, 2009),
        signed_word(550, 1461),
        signed_long(552, Ram, 0, -2600, 2600),
        long(556, Ram, 0, 0, 4_346_756),
        long(560, Ram, 0, 0, 2600),
        signed_long(564, Ram, 0, i32::MIN as i64, i32::MAX as i64),
    ],
};

impl Model {
    /// The items of this model's control table, in no order; nothing if this crate does not have them. Indirect registers are not among
    /// them.
    pub fn items(&self) -> Option<impl Iterator<Item = Item> + use<>> {
        let Differences { missing, own } = match self.number {
            xm430::MODEL => &NONE,
            1060 => &XL430,
            1120 => &XM540,
            1200 => &XL330,
            1220 => &XC330,
            2100 => &PM42,
            _ => return None,
        };
        let layout = self.layout;
        let number = xm430::MODEL_NUMBER.address();
        let model = i64::from(self.number);
        let shared = xm430::ITEMS.iter().filter(|item| !missing.contains(&item.address));
        let moved = shared.map(move |item| match (layout, item.address) {
            (_, address) if address == number => Item { default: model, ..*item },
            _ => layout.moved(item),
        });
        Some(moved.filter(|item| own.iter().all(|it| it.address != item.address)).chain(own.iter().copied()))
    }
}

impl Layout {
    fn moved(self, item: &Item) -> Item {
        let place = Register::<u8>::read(item.address, false, item.area, 0);
        Item { address: self.at(place).address(), ..*item }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::models::MODELS;
    use std::vec::Vec;

    fn items(model: &Model) -> Option<Vec<Item>> {
        let mut items: Vec<Item> = model.items()?.collect();
        items.sort_by_key(|item| item.address);
        Some(items)
    }

    #[test]
    fn every_table_is_one() {
        let tables: Vec<_> = MODELS.iter().filter_map(|model| Some((model, items(model)?))).collect();
        assert_eq!(tables.len(), 6);
        for (model, items) in tables {
            for pair in items.windows(2) {
                assert!(pair[0].end() <= pair[1].address, "{}: {pair:?}", model.name);
            }
            for item in &items {
                assert!(item.min <= item.default && item.default <= item.max, "{}: {item:?}", model.name);
                let beside = |area: &crate::IndirectArea| {
                    item.end() <= area.addresses || item.address >= area.addresses + 2 * area.length
                };
                assert!(model.indirect.iter().all(beside), "{}: {item:?}", model.name);
            }
            assert_eq!(items[0].default, i64::from(model.number), "{}", model.name);
        }
    }

    #[test]
    fn differences_are_those_of_the_manual() {
        let of = |number: u16, address: u16| {
            let items = items(Model::of(number).unwrap()).unwrap();
            crate::find(&items, address).copied().map(|item| (item.default, item.min, item.max))
        };
        assert_eq!(of(1020, 84), Some((800, 0, 16_383)));
        assert_eq!(of(1060, 102), None);
        assert_eq!(of(1060, 80), Some((4000, 0, 16_383)));
        assert_eq!(of(1120, 102), Some((0, -2047, 2047)));
        assert_eq!(of(1200, 38), Some((1750, 0, 1750)));
        assert_eq!(of(1220, 34), Some((55, 55, 140)));
        assert_eq!(of(2100, 64), None);
        assert_eq!(of(2100, 512), Some((0, 0, 1)));
        assert_eq!(of(2100, 48), Some((262_931, -263_187, 263_187)));
        assert!(Model::of(1030).unwrap().items().is_none());
    }
}
