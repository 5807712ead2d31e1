"""Names that are safe in C: no keyword, nothing of the standard library that the printed files include."""

from __future__ import annotations

import re

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

_FLOATING = """acos acosh asin asinh atan atan2 atanh cbrt ceil copysign cos cosh drem erf erfc exp exp2 exp10 expm1
    fabs fdim finite floor fma fmax fmin fmod frexp gamma gamma_r hypot ilogb isinf isnan j0 j1 jn ldexp lgamma lgamma_r
    llrint llround log log10 log1p log2 logb lrint lround modf nan nearbyint nextafter nexttoward pow pow10 powi
    remainder remquo rint round scalb scalbln scalbn significand sin sincos sinh sqrt tan tanh tgamma trunc y0 y1 yn
    cabs cacos cacosh carg casin casinh catan catanh ccos ccosh cexp cimag clog clog10 conj cpow cproj creal csin csinh
    csqrt ctan ctanh"""
_LIBRARY = """signbit isfinite isnormal fpclassify isgreater isgreaterequal isless islessequal islessgreater isunordered
    signgam matherr nans bcmp bcopy bzero ffs ffsl ffsll memccpy memchr memcmp memcpy memmem memmove mempcpy memset
    memfrob stpcpy stpncpy strcasecmp strcasestr strcat strchr strchrnul strcmp strcoll strcpy strcspn strdup strerror
    strlen strncasecmp strncat strncmp strncpy strndup strnlen strpbrk strrchr strsep strsignal strspn strstr strtok
    strtok_r strxfrm strfmon strftime strverscmp strfry basename index rindex abs labs llabs imaxabs div ldiv lldiv
    exit _Exit abort atexit alloca malloc calloc realloc aligned_alloc posix_memalign free rand srand qsort bsearch
    system getenv printf fprintf sprintf snprintf vprintf vfprintf vsprintf vsnprintf scanf fscanf sscanf vscanf
    vfscanf vsscanf puts fputs fputc putc putchar gets getc getchar fwrite fread fopen fclose remove rename signal
    raise time clock main execl execle execlp execv execve execvp fork dcgettext dgettext gettext ngettext isalnum
    isalpha isascii isblank iscntrl isdigit isgraph islower isprint ispunct isspace isupper isxdigit toascii tolower
    toupper iswalnum iswalpha iswblank iswcntrl iswdigit iswgraph iswlower iswprint iswpunct iswspace iswupper iswxdigit
    towlower towupper size_t ssize_t ptrdiff_t intptr_t uintptr_t intmax_t uintmax_t max_align_t float_t double_t
    register_t locale_t"""
_INTEGERS = {f"{u}int{kind}{bits}_t" for u in ("", "u") for kind in ("", "_least", "_fast") for bits in (8, 16, 32, 64)}
LIBRARY = frozenset({*_LIBRARY.split(), *_INTEGERS, *(f + end for f in _FLOATING.split() for end in ("", "f", "l"))})
"""Functions and types of the library, and the functions that compilers know without being told."""

_MACROS = """NULL NAN INFINITY EOF linux unix i386 near far I complex imaginary errno assert offsetof signbit
    isgreater HUGE MAXFLOAT DECIMAL_DIG DOMAIN SING OVERFLOW UNDERFLOW PLOSS TLOSS X_TLOSS SNAN SNANF SNANL
    SNANF32 SNANF32X SNANF64 SNANF64X SNANF128 math_errhandling BIG_ENDIAN LITTLE_ENDIAN PDP_ENDIAN BYTE_ORDER
    EXIT_FAILURE EXIT_SUCCESS RAND_MAX MB_CUR_MAX FD_SETSIZE NFDBITS WCONTINUED WEXITED WNOHANG WNOWAIT WSTOPPED
    WUNTRACED"""
MACROS = frozenset(_MACROS.split())
"""What a field of a struct may not be called either."""
_MACRO = re.compile(
    r"(FLT|DBL|LDBL|M|FP|MATH|SNAN)\d*_\w+|HUGE_VAL\w*|U?INT\w*_(MAX|MIN|C|WIDTH)"
    r"|(SIZE|PTRDIFF|WCHAR|WINT|SIG_ATOMIC)_(MAX|MIN|WIDTH)"
)

STORED = frozenset({"period", "periods"})
"""Fields that ``NAME_params`` and ``NAME_state`` have of their own."""


def _is_macro(name: str) -> bool:
    return name in MACROS or (name[-1:] != "_" and _MACRO.fullmatch(name) is not None)


def _plain(name: str) -> str:
    """A name in the letters of C."""
    text = "".join(c if c.isascii() and (c.isalnum() or c == "_") else f"u{ord(c):x}" for c in name)
    if text[:1].isdigit():
        text = f"n{text}"
    return text.lstrip("_") or "v"


def safe_field(name: str) -> str:
    """A name for a field of a struct: only keywords, macros and our own fields stand in its way."""
    text = _plain(name)
    stem = text.rstrip("_")
    return f"{text}_" if stem in KEYWORDS or stem in STORED or _is_macro(stem) else text


def safe(name: str, taken: frozenset[str] | set[str] = frozenset()) -> str:
    """A name for C: as it is where it can be, with an underscore behind where C or ``taken`` has it already."""
    text = _plain(name)
    while text in KEYWORDS or text in LIBRARY or text in taken or _is_macro(text):
        text += "_"
    return text


def is_identifier(name: str) -> bool:
    """Whether a name can be used in C unchanged."""
    return safe(name) == name
