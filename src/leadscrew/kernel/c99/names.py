"""Names that are safe in C: no keyword, nothing of the standard library that the printed files include."""

from __future__ import annotations

_KEYWORDS = """auto break case char const continue default do double else enum extern float for goto if inline int long
    register restrict return short signed sizeof static struct switch typedef union unsigned void volatile while
    _Bool _Complex _Imaginary asm typeof fortran near far
    alignas alignof bool constexpr false nullptr static_assert thread_local true typeof_unqual
    and and_eq bitand bitor catch char8_t char16_t char32_t class co_await co_return co_yield compl concept const_cast
    consteval constinit decltype delete dynamic_cast explicit export friend mutable namespace new noexcept not not_eq
    operator or or_eq private protected public reinterpret_cast requires static_cast template this throw try typeid
    typename using virtual wchar_t xor xor_eq"""
KEYWORDS = frozenset(_KEYWORDS.split())
"""Of C99 to C23 and of C++, so that the files can be included from either."""

_LIBRARY = """acos asin atan atan2 cbrt ceil copysign cos cosh erf erfc exp exp2 expm1 fabs fdim floor fma fmax
    fmin fmod frexp hypot ilogb ldexp lgamma llrint llround log log10 log1p log2 logb lrint lround modf
    nan nearbyint nextafter nexttoward pow remainder remquo rint round scalbln scalbn signbit sin sinh
    sqrt tan tanh tgamma trunc isfinite isinf isnan isnormal fpclassify j0 j1 jn y0 y1 yn gamma drem
    significand memchr memcmp memcpy memmove memset strcat strchr strcmp strcpy strlen index rindex abs
    labs llabs div ldiv exit abort atexit malloc calloc realloc free rand srand qsort bsearch system
    getenv printf scanf puts gets getc putc remove rename signal raise time clock main errno assert NULL
    NAN INFINITY HUGE_VAL EOF INT64_C UINT64_C int8_t int16_t int32_t int64_t uint8_t uint16_t uint32_t
    uint64_t size_t ptrdiff_t intptr_t uintptr_t linux unix i386 near far I complex imaginary register_t
    M_PI M_E DBL_MAX DBL_MIN FLT_MAX FLT_MIN"""
LIBRARY = frozenset(_LIBRARY.split())


_MACROS = """NULL NAN INFINITY HUGE_VAL EOF INT64_C UINT64_C linux unix i386 near far I complex imaginary errno assert
    M_PI M_E DBL_MAX DBL_MIN FLT_MAX FLT_MIN"""
MACROS = frozenset(_MACROS.split())
"""What a field of a struct may not be called either."""


def safe_field(name: str) -> str:
    """A name for a field of a struct: only keywords and macros stand in its way."""
    text = safe(name)
    plain = text.rstrip("_")
    return plain if plain == name and plain not in KEYWORDS | MACROS else text


def safe(name: str, taken: frozenset[str] | set[str] = frozenset()) -> str:
    """A name for C: as it is where it can be, with an underscore behind where C or ``taken`` has it already."""
    text = "".join(c if c.isascii() and (c.isalnum() or c == "_") else f"u{ord(c):x}" for c in name)
    if text[:1].isdigit():
        text = f"n{text}"
    text = text.lstrip("_") or "v"
    while text in KEYWORDS or text in LIBRARY or text in taken:
        text += "_"
    return text


def is_identifier(name: str) -> bool:
    """Whether a name can be used in C unchanged."""
    return safe(name) == name
