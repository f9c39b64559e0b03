//! Enums whose values options name by a word.

/// Shows and reads the values of an enum as their words; `$refusal` says what other text is not. Words behind `|` are
/// read, too.
macro_rules! words {
    ($Type:ty, $refusal:literal, $($value:ident = $word:literal $(| $alias:literal)*),+) => {
        impl std::fmt::Display for $Type {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str(match self {
                    $(Self::$value => $word,)+
                })
            }
        }

        impl std::str::FromStr for $Type {
            type Err = String;

            fn from_str(text: &str) -> Result<Self, String> {
                match text {
                    $($word $(| $alias)* => Ok(Self::$value),)+
                    _ => Err($refusal.to_string()),
                }
            }
        }
    };
}

pub(crate) use words;
