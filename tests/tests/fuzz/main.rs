//! Whatever a file or a command line may hold, the parsers answer with a value or an error, and
//! never with a panic.
//!
//! A second each under `cargo test`. For longer:
//! `BOLERO_RANDOM_TEST_TIME_MS=3600000 BOLERO_RANDOM_ITERATIONS=1000000000 cargo test -p copq-tests
//! --test fuzz`.

mod folder;

use std::path::Path;

use bolero::check;
use copq::{AdjustedEnv, Config, EnvSpec, Method, State};
use copq_experiments::{Plan, RunFolder, Sheet, read_config, with_changes};
use safetensors::SafeTensors;

/// Changes to a file: where (as a part of its length), what is done there, and how much of its end
/// is cut off.
pub type Damage = (Vec<(u16, u8)>, u8);

/// A sound file with damage done to it.
pub fn damaged(sound: &[u8], (changes, cut): &Damage) -> Vec<u8> {
    let mut bytes = sound.to_vec();
    for &(at, change) in changes.iter().take(8) {
        let index = usize::from(at) * bytes.len() / 65_536;
        bytes[index] ^= change;
    }
    // Mostly whole: what is cut short is refused soon.
    if *cut < 32 {
        bytes.truncate(bytes.len() * usize::from(*cut) / 32);
    }
    bytes
}

fn state() -> State {
    let mut state = State::default();
    state.put("steps", [7_u64]);
    state.child_mut("agent").put_shaped("weight", &[2, 2], [1.0_f32, 2.0, 3.0, 4.0]);
    state.child_mut("agent").put("q/safety", [0.5_f64]);
    state.child_mut("env").put("world", [1_u8, 2, 3]);
    state
}

fn file_of(state: &State) -> Vec<u8> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("checkpoint.safetensors");
    state.write_file(&path).unwrap();
    std::fs::read(path).unwrap()
}

#[test]
fn checkpoint() {
    let sound = file_of(&state());
    check!().with_type::<Damage>().for_each(|damage| {
        let bytes = damaged(&sound, damage);
        if let Ok(read) = State::from_bytes("checkpoint", &bytes) {
            assert!(read == state(), "damage was believed");
        }
    });
}

/// A file damaged by somebody who then writes the checksums that go with it.
#[test]
fn checkpoint_with_right_checksums() {
    let sound = file_of(&state());
    assert!(with_right_checksums(sound.clone()) == sound, "checksums are written otherwise");
    check!().with_type::<Damage>().for_each(|damage| {
        let bytes = with_right_checksums(damaged(&sound, damage));
        // Nothing that is read is larger than the file.
        if let Ok(read) = State::from_bytes("checkpoint", &bytes) {
            assert!(format!("{read:?}").len() < 100 * bytes.len());
        }
    });
}

/// The file as it is where its header cannot be read.
fn with_right_checksums(mut bytes: Vec<u8>) -> Vec<u8> {
    let Ok((header, metadata)) = SafeTensors::read_metadata(&bytes) else { return bytes };
    let Some(sums) = metadata.info("%checksums") else { return bytes };
    let data = 8 + header;
    let sums = data + sums.data_offsets.0..data + sums.data_offsets.1;
    let mut infos: Vec<_> = metadata.tensors().into_iter().collect();
    infos.retain(|(name, _)| name != "%checksums");
    infos.sort_by_key(|(_, info)| info.data_offsets);
    let parts =
        infos.iter().map(|(_, info)| data + info.data_offsets.0..data + info.data_offsets.1);
    let right: Vec<u64> = std::iter::once(8..data)
        .chain(parts)
        .map(|part| u64::from(crc32c::crc32c(&bytes[part])))
        .collect();
    for (place, sum) in bytes[sums].chunks_exact_mut(8).zip(right) {
        place.copy_from_slice(&sum.to_le_bytes());
    }
    bytes
}

#[test]
fn checkpoint_of_noise() {
    check!().with_type::<Vec<u8>>().for_each(|bytes| {
        assert!(State::from_bytes("checkpoint", bytes).is_err());
    });
}

#[test]
fn csv() {
    let sound = b"step,q/safety,\"a,b\"\n0,0.5,\n1000,1e-9,3\n2000,NaN,-inf\n";
    check!().with_type::<Damage>().for_each(|damage| {
        let text = String::from_utf8_lossy(&damaged(sound, damage)).into_owned();
        let Ok(sheet) = Sheet::parse(Path::new("metrics.csv"), &text) else { return };
        for name in sheet.columns() {
            assert_eq!(sheet.column(name).map(|column| column.len()), Some(sheet.steps().len()));
        }
    });
}

#[test]
fn config() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run");
    let method = Method::cop_cal();
    drop(RunFolder::create(&path, &Plan::new(&method), &method.config).unwrap());
    let file = path.join("config.toml");
    let sound = std::fs::read(&file).unwrap();
    check!().with_type::<Damage>().for_each(|damage| {
        std::fs::write(&file, damaged(&sound, damage)).unwrap();
        if let Ok(config) = read_config::<Config>(&path) {
            // What can be read can be checked.
            drop((config.plan.check(), config.settings.check()));
        }
    });
}

#[test]
fn settings_by_name() {
    let settings = Method::cop_td3_oac().config;
    let keys = ["batch", "networks.hidden", "optimism.shift", "famo", "discount", "warm_up", ""];
    check!().with_type::<(u8, String)>().for_each(|(key, text)| {
        let key = keys[usize::from(*key) % keys.len()];
        for change in [format!("{key}={text}"), text.clone()] {
            if let Ok(changed) = with_changes(&settings, &[change]) {
                drop(changed.check());
            }
        }
    });
}

#[test]
fn names_and_orders() {
    let names = ["a/hopper", "b/ant", "gym/walker2d"];
    check!().with_type::<(u8, String)>().for_each(|(name, text)| {
        let known = names[usize::from(*name) % names.len()];
        drop(copq_envs::task(text));
        drop(copq_envs::task(&format!("{known}{text}")));
        drop(Method::by_name(text));
        drop(copq::projection::by_name(text));
        let world = folder::Still(EnvSpec::new("test", 1, 1).reward("é", 1.0).reward(known, 1.0));
        drop(AdjustedEnv::new(world).order(text));
    });
}
