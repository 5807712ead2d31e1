from .job import Job as Job
from .space import Space as Space
from .tuner import tune as tune
