//! How variables and quantities are written in figures and tables: by their description, with Greek letters.

use results::description::{Description, Quantity, Statistic, Variable};

/// A symbol as it is written in equations: `φ` for `phi`.
pub fn glyph(symbol: &str) -> &str {
    match symbol {
        "alpha" => "α",
        "beta" => "β",
        "gamma" => "γ",
        "delta" => "δ",
        "epsilon" => "ε",
        "zeta" => "ζ",
        "eta" => "η",
        "theta" => "θ",
        "lambda" => "λ",
        "mu" => "μ",
        "nu" => "ν",
        "xi" => "ξ",
        "rho" => "ρ",
        "sigma" => "σ",
        "tau" => "τ",
        "phi" => "φ",
        "chi" => "χ",
        "psi" => "ψ",
        "omega" => "ω",
        "Omega" => "Ω",
        other => other,
    }
}

/// The name and the symbol of a variable: `solar angle φ`.
pub fn named(variable: &Variable) -> String {
    format!("{} {}", variable.name, glyph(&variable.symbol))
}

/// The symbol of a variable with its unit: `φ [rad]`.
pub fn short_label(variable: &Variable) -> String {
    with_unit(glyph(&variable.symbol), &variable.unit)
}

/// The name and the symbol of a variable with its unit: `solar angle φ [rad]`.
pub fn label(variable: &Variable) -> String {
    with_unit(&named(variable), &variable.unit)
}

fn with_unit(words: &str, unit: &str) -> String {
    if unit.is_empty() { words.into() } else { format!("{words} [{unit}]") }
}

/// The unit of which a density of these variables is the inverse: `rad`, `m²`; empty if they are pure numbers.
pub fn unit_of_cell(variables: &[&Variable]) -> String {
    let units: Vec<&str> = variables.iter().map(|v| v.unit.as_str()).filter(|unit| !unit.is_empty()).collect();
    match units[..] {
        [] => String::new(),
        [one] => one.into(),
        [one, other] if one == other => format!("{one}²"),
        _ => format!("({})", units.join("·")),
    }
}

/// The words for a density with its unit, which is `factor` divided by the units of the variables: `density [1/rad]`.
pub fn density_label(words: &str, factor: &str, variables: &[&Variable]) -> String {
    match (unit_of_cell(variables), factor) {
        (cell, "1") if cell.is_empty() => words.into(),
        (cell, factor) if cell.is_empty() => format!("{words} [{factor}]"),
        (cell, factor) => format!("{words} [{factor}/{cell}]"),
    }
}

/// A mean or a deviation: the letter, and the symbol of the variable that is its index.
pub fn moment_symbol<'a>(description: &'a Description, quantity: &Quantity) -> (&'static str, &'a str) {
    let letter = if quantity.statistic == Statistic::Mean { "μ" } else { "σ" };
    let variable = quantity.variables.first().and_then(|&position| description.variables.get(position));
    (letter, variable.map_or("?", |variable| glyph(&variable.symbol)))
}

/// The means and deviations of all variables: those of the first, then those of the next.
pub fn means_and_deviations(description: &Description) -> Vec<&Quantity> {
    let is_shown = |q: &&Quantity| matches!(q.statistic, Statistic::Mean | Statistic::Deviation);
    description.quantities.iter().filter(is_shown).collect()
}

/// The name of the re-entry variable, and its symbol.
pub fn reentry(description: &Description) -> (&str, &str) {
    description.reentry_variable().map_or(("?", "?"), |variable| (&variable.name, glyph(&variable.symbol)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_follow_from_names_symbols_and_units() {
        let variable = |name: &str, symbol: &str, unit: &str| Variable {
            name: name.into(),
            symbol: symbol.into(),
            unit: unit.into(),
            bounds: None,
        };
        let (phi, e) = (variable("solar angle", "phi", "rad"), variable("eccentricity", "e", ""));
        let (r, z) = (variable("distance", "r", "m"), variable("height", "z", "m"));
        assert_eq!((label(&phi), label(&e)), ("solar angle φ [rad]".into(), "eccentricity e".into()));
        assert_eq!((short_label(&phi), short_label(&z)), ("φ [rad]".into(), "z [m]".into()));
        assert_eq!(density_label("joint density", "1", &[&phi, &e]), "joint density [1/rad]");
        assert_eq!(density_label("density", "10⁻³", &[&r, &z]), "density [10⁻³/m²]");
        assert_eq!(density_label("density", "1", &[&phi, &z]), "density [1/(rad·m)]");
        assert_eq!(density_label("density", "1", &[&e]), "density");
    }
}
