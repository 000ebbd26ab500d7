//! What a function may return at once, by the name of its type.

use syn::{Expr, GenericArgument, PathArguments, ReturnType, Type, parse_quote};

pub fn of(output: &ReturnType) -> Vec<Expr> {
    match output {
        ReturnType::Default => vec![parse_quote!(())],
        ReturnType::Type(_, found) => of_type(found),
    }
}

fn of_type(found: &Type) -> Vec<Expr> {
    match found {
        Type::Tuple(tuple) if tuple.elems.is_empty() => vec![parse_quote!(())],
        Type::Tuple(tuple) => {
            let firsts: Vec<Expr> =
                tuple.elems.iter().filter_map(|one| of_type(one).into_iter().next()).collect();
            if firsts.len() < tuple.elems.len() {
                Vec::new()
            } else {
                vec![parse_quote!((#(#firsts),*))]
            }
        }
        Type::Path(path) => path.path.segments.last().map(of_segment).unwrap_or_default(),
        _ => Vec::new(),
    }
}

fn of_segment(segment: &syn::PathSegment) -> Vec<Expr> {
    match segment.ident.to_string().as_str() {
        "bool" => vec![parse_quote!(true), parse_quote!(false)],
        "f64" | "f32" => vec![parse_quote!(0.0), parse_quote!(1.0)],
        "u8" | "u16" | "u32" | "u64" | "usize" | "i32" | "i64" | "isize" => {
            vec![parse_quote!(0), parse_quote!(1)]
        }
        "Option" => vec![parse_quote!(None)],
        "Vec" => vec![parse_quote!(Vec::new())],
        "Vector" => vec![parse_quote!([0.0; 3])],
        "Result" => argument(segment)
            .map(of_type)
            .unwrap_or_default()
            .into_iter()
            .map(|value| parse_quote!(Ok(#value)))
            .collect(),
        _ => Vec::new(),
    }
}

fn argument(segment: &syn::PathSegment) -> Option<&Type> {
    let PathArguments::AngleBracketed(arguments) = &segment.arguments else { return None };
    arguments.args.iter().find_map(|argument| match argument {
        GenericArgument::Type(found) => Some(found),
        _ => None,
    })
}
