//! Puts all mutants of some source files into them at once: `mutants FILE... > TABLE`. Each is a
//! branch that the variable `HULLWRIGHT_MUTANT` takes by its number, so that one build serves for
//! all of them (Untch, Offutt, Harrold, "Mutation analysis using mutant schemata", 1993). Without
//! it the sources do what they did.
//!
//! The files are overwritten: `mutants/run` does so in a copy. Operators are those of
//! cargo-mutants: comparisons, arithmetic and logic are exchanged, negations are left out,
//! functions return at once.

mod values;

use proc_macro2::Span;
use quote::{ToTokens, quote};
use syn::spanned::Spanned;
use syn::visit_mut::{self, VisitMut};
use syn::{BinOp, Expr, parse_quote};

/// A comma-separated list of numbers that do not compile, and are left out.
const SKIP: &str = "MUTANTS_SKIP";

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let unviable: Vec<u32> = std::env::var(SKIP)
        .unwrap_or_default()
        .split(',')
        .filter_map(|number| number.parse().ok())
        .collect();
    let mut count = 0;
    for path in std::env::args().skip(1) {
        let text = std::fs::read_to_string(&path)?;
        let mut file = syn::parse_file(&text)?;
        let mut mutator = Mutator { path: &path, function: Vec::new(), count, unviable: &unviable };
        mutator.visit_file_mut(&mut file);
        count = mutator.count;
        std::fs::write(&path, prettyplease::unparse(&file))?;
    }
    Ok(())
}

struct Mutator<'a> {
    path: &'a str,
    function: Vec<String>,
    count: u32,
    unviable: &'a [u32],
}

impl Mutator<'_> {
    /// Numbers a mutant and writes its line of the table; `None` if it is to be left out.
    fn number(&mut self, span: Span, what: &str) -> Option<u32> {
        self.count += 1;
        let (number, line) = (self.count, span.start().line);
        if self.unviable.contains(&number) {
            return None;
        }
        println!("{number}\t{}:{line}\t{}\t{what}", self.path, self.function.join("::"));
        Some(number)
    }

    /// A choice between the expression and others in its place.
    fn choice(&mut self, span: Span, expression: &mut Expr, others: Vec<(String, Expr)>) {
        let (mut chosen, mut is_any) = (expression.clone(), false);
        for (what, other) in others {
            if let Some(number) = self.number(span, &what) {
                chosen = parse_quote!(
                    if crate::mutation::is_on(#number) { #other } else { #chosen }
                );
                is_any = true;
            }
        }
        // In brackets, since it may stand where a statement would end after the block.
        if is_any {
            *expression = parse_quote!((#chosen));
        }
    }

    fn mutate_function(&mut self, signature: &syn::Signature, block: &mut syn::Block) {
        if signature.constness.is_some() {
            return;
        }
        self.function.push(signature.ident.to_string());
        visit_mut::visit_block_mut(self, block);
        for value in values::of(&signature.output) {
            let what = format!("returns {}", value.to_token_stream());
            if let Some(number) = self.number(signature.ident.span(), &what) {
                block
                    .stmts
                    .insert(0, parse_quote!(if crate::mutation::is_on(#number) { return #value; }));
            }
        }
        self.function.pop();
    }
}

fn is_test(attributes: &[syn::Attribute]) -> bool {
    attributes.iter().any(|attribute| {
        let text = attribute.to_token_stream().to_string();
        text.contains("test")
    })
}

impl VisitMut for Mutator<'_> {
    fn visit_item_mod_mut(&mut self, item: &mut syn::ItemMod) {
        if !is_test(&item.attrs) {
            visit_mut::visit_item_mod_mut(self, item);
        }
    }

    fn visit_item_fn_mut(&mut self, item: &mut syn::ItemFn) {
        if !is_test(&item.attrs) {
            self.mutate_function(&item.sig, &mut item.block);
        }
    }

    fn visit_item_impl_mut(&mut self, item: &mut syn::ItemImpl) {
        self.function.push(item.self_ty.to_token_stream().to_string());
        visit_mut::visit_item_impl_mut(self, item);
        self.function.pop();
    }

    fn visit_impl_item_fn_mut(&mut self, item: &mut syn::ImplItemFn) {
        if !is_test(&item.attrs) {
            self.mutate_function(&item.sig, &mut item.block);
        }
    }

    // Constants can ask for nothing when the program runs.
    fn visit_item_const_mut(&mut self, _: &mut syn::ItemConst) {}
    fn visit_item_static_mut(&mut self, _: &mut syn::ItemStatic) {}
    fn visit_impl_item_const_mut(&mut self, _: &mut syn::ImplItemConst) {}
    fn visit_type_mut(&mut self, _: &mut syn::Type) {}
    fn visit_generic_argument_mut(&mut self, _: &mut syn::GenericArgument) {}
    fn visit_pat_mut(&mut self, _: &mut syn::Pat) {}

    fn visit_expr_mut(&mut self, expression: &mut Expr) {
        let others = match &*expression {
            Expr::Binary(binary) => exchanged(binary),
            Expr::Unary(unary) if !matches!(unary.op, syn::UnOp::Deref(_)) => {
                vec![(format!("no {}", unary.op.to_token_stream()), (*unary.expr).clone())]
            }
            _ => Vec::new(),
        };
        let span = match &*expression {
            Expr::Binary(binary) => binary.op.span(),
            other => other.span(),
        };
        match &mut *expression {
            Expr::Repeat(repeat) => self.visit_expr_mut(&mut repeat.expr),
            Expr::Const(_) => {}
            other => visit_mut::visit_expr_mut(self, other),
        }
        self.choice(span, expression, others);
    }
}

/// The same with other operators.
fn exchanged(binary: &syn::ExprBinary) -> Vec<(String, Expr)> {
    // What binds a name can't be put into a choice.
    if binds(&binary.left) || binds(&binary.right) {
        return Vec::new();
    }
    let others: &[&str] = match binary.op {
        BinOp::Eq(_) => &["!="],
        BinOp::Ne(_) => &["=="],
        BinOp::Lt(_) => &["<=", ">"],
        BinOp::Gt(_) => &[">=", "<"],
        BinOp::Le(_) => &["<", ">"],
        BinOp::Ge(_) => &[">", "<"],
        BinOp::And(_) => &["||"],
        BinOp::Or(_) => &["&&"],
        BinOp::Add(_) => &["-"],
        BinOp::Sub(_) => &["+"],
        BinOp::Mul(_) => &["+"],
        BinOp::Div(_) | BinOp::Rem(_) => &["*"],
        BinOp::BitAnd(_) | BinOp::BitXor(_) => &["|"],
        BinOp::BitOr(_) => &["&"],
        BinOp::Shl(_) => &[">>"],
        BinOp::Shr(_) => &["<<"],
        BinOp::AddAssign(_) => &["-="],
        BinOp::SubAssign(_) => &["+="],
        BinOp::MulAssign(_) => &["+="],
        BinOp::DivAssign(_) => &["*="],
        BinOp::BitAndAssign(_) => &["|="],
        BinOp::BitOrAssign(_) => &["&="],
        _ => &[],
    };
    let old = binary.op.to_token_stream();
    let exchange = |new: &&str| {
        let op: BinOp = syn::parse_str(new).expect("an operator");
        let (left, right) = (&binary.left, &binary.right);
        // Another operator may bind otherwise than the one whose operands these were.
        let other: Expr = syn::parse2(quote!((#left) #op (#right))).expect("an expression");
        (format!("{new} for {old}"), other)
    };
    others.iter().map(exchange).collect()
}

fn binds(expression: &Expr) -> bool {
    match expression {
        Expr::Let(_) => true,
        Expr::Binary(binary) => binds(&binary.left) || binds(&binary.right),
        _ => false,
    }
}
