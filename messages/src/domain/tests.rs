use std::os::unix::fs::chown;

use super::*;

fn place(name: &str) -> Place {
    let root = std::env::temp_dir().join(format!("pc-place-{name}-{}", std::process::id()));
    Place { root, prefix: format!("pc-place-{name}-{}-", std::process::id()) }
}

#[test]
fn a_domain_is_its_owners_alone() {
    let place = place("own");
    place.create().unwrap();
    assert_eq!(place.root.metadata().unwrap().mode() & 0o777, 0o700);
    std::fs::set_permissions(&place.root, std::fs::Permissions::from_mode(0o755)).unwrap();
    assert!(place.create().is_err(), "others can enter");
    place.remove().unwrap();
}

#[test]
fn a_folder_that_somebody_else_has_put_there_is_refused() {
    let place = place("foreign");
    place.create().unwrap();
    if chown(&place.root, Some(65534), Some(65534)).is_err() {
        println!("skipped: only root can give folders away");
    } else {
        assert!(place.create().is_err());
    }
    place.remove().unwrap();
}

#[test]
fn the_file_of_a_publisher_is_as_long_as_foretold() {
    let (place, items) = (place("segment"), 1000);
    let capacity = Capacity { propagators: 2, cases: 2, snapshots: 3, hosts: 0 };
    let held = HeldDomain::create(&place, &capacity).unwrap();
    let longest = || {
        let files = place.files_in_shared_memory().unwrap().into_iter();
        files.map(|file| file.metadata().unwrap().len()).max().unwrap()
    };
    let sender = Domain::enter(&place, "sender").unwrap();
    let is_as_foretold = |foretold: u64| longest() <= foretold && longest() > foretold / 10 * 9;
    let snapshots = sender.outlet::<Snapshot>(items).unwrap();
    assert!(is_as_foretold(segment_bytes::<Snapshot>(&capacity, items as u64)), "{}", longest());
    let densities = sender.outlet::<Density>(items).unwrap();
    assert!(is_as_foretold(segment_bytes::<Density>(&capacity, items as u64)), "{}", longest());
    drop((snapshots, densities, sender));
    drop(held);
    place.remove().unwrap();
}

#[test]
fn a_domain_without_a_prefix_removes_nothing() {
    assert!(Place { prefix: String::new(), ..place("bare") }.remove().is_err());
}
