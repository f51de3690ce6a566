//! Which hosts may join, and which have.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use super::contact::Contact;
use super::greeting::Hello;

/// The process that has joined as each host, and when it was last heard of.
type Present = BTreeMap<String, (u64, Arc<Contact>)>;

/// Which hosts may join, with what each is told, and which have joined.
#[derive(Debug)]
pub struct Register<P> {
    plans: BTreeMap<String, P>,
    present: Mutex<Present>,
}

impl<P: Clone> Register<P> {
    /// Nobody has joined yet.
    pub fn of(plans: BTreeMap<String, P>) -> Self {
        Self { plans, present: Mutex::default() }
    }

    /// The plan of a host that greets, and its contact if it was not there before.
    ///
    /// # Errors
    /// Why it cannot join.
    pub fn welcome(&self, hello: &Hello) -> Result<(P, Option<Arc<Contact>>), String> {
        hello.check().inspect_err(|why| tracing::error!("{why}"))?;
        let Some(plan) = self.plans.get(&hello.host) else {
            let names: Vec<&str> = self.plans.keys().map(String::as_str).collect();
            let why = format!("[hosts] at home names no host \"{}\"; there are {}", hello.host, names.join(", "));
            tracing::warn!("{why}");
            return Err(why);
        };
        let mut present = self.present();
        match present.get(&hello.host) {
            Some((process, _)) if *process == hello.process => return Ok((plan.clone(), None)),
            Some((_, contact)) if !contact.is_gone() => {
                return Err(format!("another process has joined as {} and is alive, or was a moment ago", hello.host));
            }
            _ => {}
        }
        let contact = Arc::new(Contact::with_worker());
        present.insert(hello.host.clone(), (hello.process, Arc::clone(&contact)));
        Ok((plan.clone(), Some(contact)))
    }

    /// The contact with a process that has joined, unless another one has taken its place.
    pub fn contact(&self, process: u64) -> Option<Arc<Contact>> {
        self.present().values().find(|(known, _)| *known == process).map(|(_, contact)| Arc::clone(contact))
    }

    /// The processes that are there, each with the name of its host.
    pub fn alive(&self) -> BTreeMap<u64, String> {
        let present = self.present();
        let alive = present.iter().filter(|(_, (_, contact))| !contact.is_gone());
        alive.map(|(host, (process, _))| (*process, host.clone())).collect()
    }

    fn present(&self) -> MutexGuard<'_, Present> {
        self.present.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_belongs_to_one_process_until_that_is_gone() {
        let register = Register::of(BTreeMap::from([("a".to_owned(), "the plan")]));
        let contact = register.welcome(&Hello::of("a", 1)).unwrap().1.unwrap();
        assert!(register.welcome(&Hello::of("a", 1)).unwrap().1.is_none(), "it is there already");
        assert!(register.welcome(&Hello::of("a", 2)).unwrap_err().contains("another process has joined as a"));
        assert_eq!(register.alive(), BTreeMap::from([(1, "a".to_owned())]));
        contact.end();
        assert!(register.alive().is_empty());
        assert!(register.welcome(&Hello::of("a", 2)).unwrap().1.is_some());
        assert!(register.contact(1).is_none() && register.contact(2).is_some());
        assert!(register.welcome(&Hello::of("b", 3)).unwrap_err().contains("no host \"b\"; there are a"));
    }
}
