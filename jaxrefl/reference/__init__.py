"""Reference vectors for other renderers, and what their own vectors say about them.

`reference_vectors` tabulates a model at directions that find mistakes, `write` puts the table into a CSV, JSON or C
file together with its conventions. `read` takes a table from another renderer, `compare` says to how many digits it
agrees with the model, and `explain` tries the usual differences of convention until one makes the two agree.
"""

from .agreement import Agreement as Agreement
from .agreement import Comparison as Comparison
from .agreement import compare as compare
from .directions import spread_directions as spread_directions
from .mismatch import CONSTANT as CONSTANT
from .mismatch import SHARE as SHARE
from .mismatch import Explanation as Explanation
from .mismatch import explain as explain
from .read import Given as Given
from .read import read as read
from .vectors import Vectors as Vectors
from .vectors import evaluate as evaluate
from .vectors import reference_vectors as reference_vectors
from .write import CONVENTIONS as CONVENTIONS
from .write import check_path as check_path
from .write import identifier as identifier
from .write import write as write
