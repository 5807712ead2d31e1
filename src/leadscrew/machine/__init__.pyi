from .axis_study import study as study
from .file import MachineFile as MachineFile
from .file import read as read
from .file import write as write
from .from_fit import from_axis as from_axis
from .from_fit import from_linear as from_linear
