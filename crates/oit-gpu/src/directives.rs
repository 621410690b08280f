//! `enable` directives of a program put together from several texts.

use std::borrow::Cow;

/// WGSL as naga takes it. WGSL wants `enable` before all else, and a program is a concatenation of
/// texts of which each may need something: so every line that starts with `enable ` (spaces before
/// it are no matter) may stand anywhere, and what it enables is named once at the start of the
/// first line. Lines keep their numbers. `enable subgroups;` is left out: naga has subgroup
/// operations without it and, as of version 30, refuses it as not yet implemented.
///
/// Only lines are looked at, so a comment that starts a line with `enable ` is taken for one too.
pub(crate) fn hoisted(wgsl: &str) -> Cow<'_, str> {
    let mut names: Vec<&str> = Vec::new();
    let mut rest = String::new();
    let mut last = 0;
    let mut start = 0;
    for line in wgsl.split_inclusive('\n') {
        let directive = line.trim_start().strip_prefix("enable ");
        if let Some((list, after)) = directive.and_then(|list| list.split_once(';')) {
            for name in list.split(',').map(str::trim).filter(|name| !name.is_empty()) {
                if name != "subgroups" && !names.contains(&name) {
                    names.push(name);
                }
            }
            rest.push_str(&wgsl[last..start]);
            rest.push_str(after);
            last = start + line.len();
        }
        start += line.len();
    }
    if last == 0 {
        return Cow::Borrowed(wgsl);
    }
    rest.push_str(&wgsl[last..]);
    match names.is_empty() {
        true => Cow::Owned(rest),
        false => Cow::Owned(format!("enable {}; {rest}", names.join(", "))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directives_go_to_the_top_and_lines_keep_their_numbers() {
        let plain = "fn f() {}\nconst enabled = 1;\n// enable f16;\n";
        assert!(matches!(hoisted(plain), Cow::Borrowed(text) if text == plain));
        let parts =
            "const a = 1;\n  enable f16, subgroups;\nconst b = 1; \nenable f16; const c = 1;";
        assert_eq!(
            hoisted(parts),
            "enable f16; const a = 1;\n\nconst b = 1; \n const c = 1;".to_owned()
        );
        assert_eq!(hoisted("enable subgroups;\r\nfn f() {}"), "\r\nfn f() {}".to_owned());
        // What is no directive stays, for the compiler to refuse.
        assert_eq!(hoisted("enable f16\n"), "enable f16\n");
    }
}
