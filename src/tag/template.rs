//! Templates for `bsn!` whose defaults are those of their components: what Bevy derives has the
//! default of each field's type instead.

/// Declares the template of a component with a handle, by fields with a template of their own and
/// others.
macro_rules! template_like_default {
    ($component:ident => $template:ident {
        handle $handle:ident: $handle_template:ty,
        $($field:ident: $type:ty,)*
    }) => {
        #[allow(missing_docs)]
        pub struct $template {
            pub $handle: $handle_template,
            $(pub $field: $type,)*
        }

        impl Default for $template {
            fn default() -> Self {
                let $component { $($field,)* .. } = $component::default();
                Self { $handle: Default::default(), $($field,)* }
            }
        }

        impl bevy::ecs::template::Template for $template {
            type Output = $component;

            fn build_template(
                &self,
                context: &mut bevy::ecs::template::TemplateContext,
            ) -> bevy::ecs::error::Result<$component> {
                let $handle = self.$handle.build_template(context)?;
                Ok($component { $handle, $($field: self.$field.clone(),)* })
            }

            fn clone_template(&self) -> Self {
                let $handle = bevy::ecs::template::Template::clone_template(&self.$handle);
                Self { $handle, $($field: self.$field.clone(),)* }
            }
        }

        impl bevy::ecs::template::FromTemplate for $component {
            type Template = $template;
        }

        // Tells the compiler that this is no type that is its own template.
        impl Unpin for $component
        where
            for<'a> [()]: bevy::ecs::template::SpecializeFromTemplate
        {
        }
    };
}

pub(crate) use template_like_default;
