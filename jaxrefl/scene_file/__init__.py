"""Scene files: TOML <-> `Scene`, camera and settings.

One grammar for everything: the table ``[objects.glass.surface]`` with its key ``eta`` is the leaf
``scene.objects["glass"].surface.eta``, the setting ``objects.glass.surface.eta=1.33`` and what an error message names.
A model is a table with ``type``; its keys, ranges and defaults are those that its dataclass declares. In the place of
a colour may stand a table of type Checker or Image. Angles are in degrees, in keys that end in ``_deg``.
"""

from .catalog import Settings as Settings
from .document import SceneFile as SceneFile
from .document import json_schema as json_schema
from .document import load as load
from .document import loads as loads
from .document import parse as parse
from .document import set_values as set_values
from .examples import example as example
from .examples import examples as examples
from .examples import find as find
from .examples import starter as starter
from .write import dumps as dumps
