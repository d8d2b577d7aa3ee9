//! Messages of J1939: whose they are, and what says that there is no value.

// A helper that fails has failed the test that calls it.
#![allow(clippy::unwrap_used)]

use std::collections::BTreeSet;
use std::fs;

use fingerpost_io::{CanDatabase, CanFrame, CanId, NoValue, SignalLayout, SignalLog, SignalReading};
use tempfile::TempDir;

/// A signal of one byte in a message of this identifier, and what else is said.
fn j1939_signal(id: u32, said: &str) -> SignalLayout {
    signal_of_bits(id, "0|8@1+", said)
}

/// A signal of these bits in a message of this 29-bit identifier, and what else is said.
fn signal_of_bits(id: u32, bits: &str, said: &str) -> SignalLayout {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("truck.dbc");
    let number = u64::from(id) + (1 << 31);
    let text = format!(
        "VERSION \"\"\n\nBU_: E\n\nBO_ {number} M: 8 E\n SG_ S : {bits} (1,0) [0|0] \"\" E\n\n{}\n",
        said.replace("ID", &number.to_string())
    );
    fs::write(&path, text).unwrap();
    CanDatabase::read(&path).unwrap().signal("M.S").unwrap()
}

const FORMATS: &str =
    "BA_DEF_ BO_ \"VFrameFormat\" ENUM \"StandardCAN\",\"ExtendedCAN\",\"reserved\",\"J1939PG\";\n";

#[test]
fn a_group_of_j1939_is_found_whoever_sends_it() {
    let by_format = format!("{FORMATS}BA_ \"VFrameFormat\" BO_ ID 3;\n");
    let by_default = format!("{FORMATS}BA_DEF_DEF_ \"VFrameFormat\" \"J1939PG\";\n");
    let by_protocol = "BA_DEF_ \"ProtocolType\" STRING ;\nBA_ \"ProtocolType\" \"J1939\";\n";
    let is_in = |signal: &SignalLayout, id| signal.is_in(CanId::Extended(id));
    for said in [&by_format, &by_default, by_protocol] {
        let broadcast = j1939_signal(0x18FE_F121, said);
        for (id, expected) in [
            (0x18FE_F121, true),
            (0x18FE_F100, true),
            (0x0CFE_F1FE, true),
            (0x18FE_F221, false),
            (0x18FD_F121, false),
            (0x19FE_F121, false),
        ] {
            assert_eq!(is_in(&broadcast, id), expected, "{id:08X} {said}");
        }
        // To a receiver, whose address is no part of the group.
        let addressed = j1939_signal(0x18EF_0021, said);
        assert!(is_in(&addressed, 0x1CEF_2703) && !is_in(&addressed, 0x18EE_0021), "{said}");
    }
    // Nobody's address says it where nothing else does.
    assert!(is_in(&j1939_signal(0x18FE_F1FE, ""), 0x18FE_F100));
    assert!(!is_in(&j1939_signal(0x18FE_F121, ""), 0x18FE_F100));
    let plain = format!("{FORMATS}BA_ \"VFrameFormat\" BO_ ID 1;\n{by_protocol}");
    assert!(!is_in(&j1939_signal(0x18FE_F1FE, &plain), 0x18FE_F100), "its own format says otherwise");
    assert!(!j1939_signal(0x0000_01FE, "").is_in(CanId::Standard(0x1FE)));
}

#[test]
fn a_log_names_what_came_and_who_sent_it() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("truck.log");
    fs::write(&path, "(1.0) can0 18FEF100#0800\n(1.1) can0 0CFEF10B#0900\n(1.2) can1 123#00\n").unwrap();
    let signals = [j1939_signal(0x18FE_F1FE, ""), j1939_signal(0x18FE_F2FE, "")];
    let log = SignalLog::read(&path, Some("can0"), &signals).unwrap();
    assert_eq!(log.samples[0].iter().map(|sample| sample.value).collect::<Vec<_>>(), [8.0, 9.0]);
    let named = |ids: &BTreeSet<CanId>| ids.iter().map(ToString::to_string).collect::<Vec<_>>();
    assert_eq!(named(&log.senders[0]), ["0CFEF10B", "18FEF100"]);
    assert!(log.samples[1].is_empty() && log.senders[1].is_empty());
    assert_eq!(named(&log.came), ["0CFEF10B", "18FEF100"]);
    assert_eq!(log.interfaces.iter().collect::<Vec<_>>(), ["can0", "can1"]);
}

#[test]
fn values_of_j1939_that_stand_for_none_are_none() {
    use NoValue::{Error, NotAvailable};
    let no = |reason| Some(SignalReading::NoValue(reason));
    let value = |value| Some(SignalReading::Value(value));
    for (bits, raw, expected) in [
        ("0|8@1+", 0xFF_u64, no(NotAvailable)),
        ("0|8@1+", 0xFE, no(Error)),
        ("0|8@1+", 0xFA, value(250.0)),
        ("0|8@1+", 0xFD, value(253.0)),
        ("0|16@1+", 0xFFFF, no(NotAvailable)),
        ("0|16@1+", 0xFF00, no(NotAvailable)),
        ("0|16@1+", 0xFE7F, no(Error)),
        ("0|16@1+", 0xFAFF, value(f64::from(0xFAFF))),
        ("0|16@1+", 0x00FF, value(255.0)),
        // The other order of bytes: the first one is the highest.
        ("7|16@0+", 0x00FF, no(NotAvailable)),
        ("7|16@0+", 0xFF00, value(255.0)),
        ("0|32@1+", 0xFFFF_FFFF, no(NotAvailable)),
        ("0|32@1+", 0xFE00_0000, no(Error)),
        ("0|32@1+", 0xFAFF_FFFF, value(f64::from(0xFAFF_FFFF_u32))),
        ("4|2@1+", 0b11_0000, no(NotAvailable)),
        ("4|2@1+", 0b10_0000, no(Error)),
        ("4|2@1+", 0b01_1111, value(1.0)),
        // Sizes that the standard gives no such values.
        ("0|4@1+", 0xF, value(15.0)),
        ("0|24@1+", 0xFF_FFFF, value(f64::from(0xFF_FFFF))),
        ("0|1@1+", 1, value(1.0)),
        // A number with sign is none of the standard's.
        ("0|8@1-", 0xFF, value(-1.0)),
    ] {
        let frame = |id| CanFrame::new(id, &raw.to_le_bytes()).unwrap();
        let of_group = signal_of_bits(0x18FE_F1FE, bits, "");
        assert_eq!(of_group.decode(&frame(CanId::Extended(0x18FE_F100))), expected, "{bits} {raw:X}");
        // The same bits in a message that is none of J1939.
        let plain = signal_of_bits(0x18FE_F121, bits, "");
        let read = plain.decode(&frame(plain.message)).unwrap();
        assert!(read.value().is_some(), "{bits} {raw:X}: {read:?}");
    }
}

#[test]
fn a_log_counts_what_has_no_value_and_senders_by_their_addresses() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("truck.log");
    // One sender with two priorities, another; and to two receivers in the last group.
    fs::write(
        &path,
        "(1.0) can0 18FEF100#FF00\n(1.1) can0 0CFEF100#0900\n(1.2) can0 18FEF10B#FE00\n(1.3) can0 18FEF100#FF\n\
         (1.4) can0 18EF2703#01\n(1.5) can0 18EF0003#02\n",
    )
    .unwrap();
    let by_format = format!("{FORMATS}BA_ \"VFrameFormat\" BO_ ID 3;\n");
    let signals = [j1939_signal(0x18FE_F1FE, ""), j1939_signal(0x18EF_0021, &by_format)];
    let log = SignalLog::read(&path, None, &signals).unwrap();
    let no_values = log.no_values[0];
    assert_eq!((no_values.not_available, no_values.errors, no_values.count()), (2, 1, 3));
    assert_eq!(no_values.first_s, Some(1.0));
    assert_eq!(log.samples[0].iter().map(|sample| sample.value).collect::<Vec<_>>(), [9.0]);
    assert_eq!((log.senders[0].len(), log.senders[1].len()), (2, 1));
    assert_eq!((log.samples[1].len(), log.no_values[1].count()), (2, 0));
}
