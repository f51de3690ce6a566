use std::path::Path;

use nodes::files::input::InputFile;
use nodes::files::map_file::MapFile;
use tempfile::TempDir;

use super::*;
use crate::map::prepare;

const SCENARIO: &str = "name = \"s\"\n[orbit]\nsemi_major_axis = 2.5\narea_to_mass = 10\nreflectivity = 1.3\n[initial]\nphi = 2.2\n\
     e = 0.145\ndelta_phi = 0.39\ndelta_e = 0.05\n[times]\nat = [0.0, 1.0]\n[disposal]\naltitude = \"120 km\"\n";
/// A map of 5 columns of 3 points.
const MAP: &str = "scenario = \"s.toml\"\n[quantity]\nname = \"reentry\"\nwithin = 10\n[vary]\n\
     \"orbit.semi_major_axis\" = { from = 2, to = 3, count = 5 }\n\"orbit.area_to_mass\" = [1, 2, 3]\n";

fn allotment() -> (TempDir, Allotment, Arc<Tally>) {
    let input = |text| InputFile::from_text(Path::new("m.toml"), text);
    let map = MapFile::check_with_scenario(&input(MAP), &input(SCENARIO)).unwrap();
    let folder = tempfile::tempdir().unwrap();
    prepare(&map, &folder.path().join("map")).unwrap();
    let tally = Arc::new(Tally::of(0, 1));
    let kept = Computed::open(&folder.path().join("map")).unwrap();
    let allotment = Allotment::new(kept, Parts::of(&map).unwrap(), Arc::clone(&tally));
    (folder, allotment, tally)
}

fn numbers(value: f64) -> Found {
    Ok(vec![Estimated { value, error: 0.0 }; 3])
}

fn there(processes: &[u64]) -> BTreeMap<u64, String> {
    processes.iter().map(|process| (*process, format!("worker-{process}"))).collect()
}

#[test]
fn a_part_is_given_to_one_process_and_again_to_it_if_the_answer_was_lost() {
    let (_folder, allotment, _) = allotment();
    allotment.attend(there(&[7, 8]));
    allotment.lay_out(&[(0, 0), (2, 0), (4, 0)]);
    assert_eq!(allotment.next_at_home().unwrap().unwrap(), [(0, 0)]);
    assert_eq!(allotment.take(7), [(2, 0)]);
    assert_eq!(allotment.take(7), [(2, 0)], "the first answer may be lost");
    assert_eq!(allotment.take(8), [(4, 0)]);
    allotment.bring(7, (2, 0), numbers(0.2));
    assert!(allotment.take(7).is_empty(), "the others have the rest");
    allotment.bring(HOME, (0, 0), numbers(0.0));
    allotment.bring(8, (4, 0), numbers(0.4));
    assert!(allotment.next_at_home().unwrap().is_none());
    assert_eq!(allotment.collect().into_keys().collect::<Vec<_>>(), [(0, 0), (2, 0), (4, 0)]);
}

#[test]
fn what_a_process_that_is_gone_had_is_given_to_another_and_what_comes_twice_is_taken_once() {
    let (folder, allotment, _) = allotment();
    assert_eq!(allotment.attend(there(&[7, 8])), (vec!["worker-7".into(), "worker-8".into()], Vec::new()));
    allotment.lay_out(&[(0, 0), (1, 0)]);
    assert_eq!(allotment.take(7), [(0, 0)]);
    assert_eq!(allotment.attend(there(&[8])), (Vec::new(), vec!["worker-7".into()]));
    assert_eq!(allotment.take(8), [(0, 0)]);
    // It was not gone but slow.
    allotment.bring(7, (0, 0), numbers(0.25));
    allotment.bring(8, (0, 0), numbers(0.75));
    allotment.bring(8, (3, 0), numbers(0.5));
    assert_eq!(allotment.take(8), [(1, 0)]);
    allotment.bring(8, (1, 0), numbers(0.5));
    assert!(allotment.next_at_home().unwrap().is_none());
    let found = allotment.collect();
    assert_eq!((found.len(), found[&(0, 0)][0].value), (2, 0.25), "a part that nobody asked for is left out");
    drop(allotment);
    assert_eq!(Computed::open(&folder.path().join("map")).unwrap().known(), &found);
}

#[test]
fn home_waits_for_what_others_have_and_takes_it_over_when_they_are_gone() {
    let (_folder, allotment, _) = allotment();
    allotment.attend(there(&[7]));
    allotment.lay_out(&[(0, 0)]);
    assert_eq!(allotment.take(7), [(0, 0)]);
    std::thread::scope(|scope| {
        let home = scope.spawn(|| allotment.next_at_home().unwrap().unwrap());
        allotment.attend(there(&[]));
        assert_eq!(home.join().unwrap(), [(0, 0)]);
    });
}

#[test]
fn a_mistake_at_a_point_ends_the_map_wherever_it_was_found() {
    let (_folder, first, _) = allotment();
    first.attend(there(&[7]));
    first.lay_out(&[(0, 0), (1, 0)]);
    first.bring(7, first.take(7)[0], Err("s-3: no orbit".into()));
    assert_eq!(first.next_at_home().unwrap_err(), "s-3: no orbit");
    first.bring(HOME, (1, 0), numbers(0.5));
    assert_eq!(first.outcome(), Some(Outcome::Failed("s-3: no orbit".into())));
    let (_folder, second, _) = allotment();
    second.attend(there(&[7]));
    second.lay_out(&[(0, 0)]);
    second.bring(7, (0, 0), numbers(0.5).map(|numbers| numbers[..2].to_vec()));
    let told = second.next_at_home().unwrap_err();
    assert_eq!(told, "part (0, 0) of the map came from worker-7 with 2 points, it must have 3");
}

#[test]
fn a_map_that_is_interrupted_gives_nothing_out_but_keeps_what_is_brought() {
    let (folder, allotment, _) = allotment();
    allotment.attend(there(&[7]));
    allotment.lay_out(&[(0, 0), (1, 0)]);
    assert_eq!(allotment.take(7), [(0, 0)]);
    assert!(allotment.is_shared() && allotment.interrupt());
    allotment.next_at_home().unwrap_err();
    assert_eq!(allotment.outcome(), Some(Outcome::Interrupted));
    allotment.bring(7, (0, 0), numbers(0.25));
    assert_eq!(allotment.with_count(|count| count), 1);
    drop(allotment);
    assert_eq!(Computed::open(&folder.path().join("map")).unwrap().known().len(), 1);
    let (_folder, complete, _) = self::allotment();
    complete.end(Outcome::Complete);
    assert!(!complete.interrupt(), "there is nothing to interrupt any more");
}
