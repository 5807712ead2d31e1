from .file import HalFile as HalFile
from .file import read as read
from .machine import HalMachine as HalMachine
from .show import Hal as Hal
from .show import running as running
