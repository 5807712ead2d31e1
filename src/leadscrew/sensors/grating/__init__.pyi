from ._counter import grating_counter as grating_counter
from ._counting import (
    comparators as comparators,
)
from ._counting import (
    counts as counts,
)
from ._counting import (
    fastest as fastest,
)
from ._counting import (
    longest_period as longest_period,
)
from ._counting import (
    sectors as sectors,
)
from ._moire import GRATING as GRATING
from ._moire import fringe_width as fringe_width
from ._moire import small_angle_error as small_angle_error
from ._quadrature import (
    SignalErrors as SignalErrors,
)
from ._quadrature import (
    first_order_error as first_order_error,
)
from ._quadrature import (
    interpolation_error as interpolation_error,
)
from ._quadrature import (
    quadrature as quadrature,
)
from ._ruler import grating_ruler as grating_ruler
