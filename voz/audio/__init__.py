"""Where sound comes from and goes to.

Between the parts, sound is 16 kHz, one channel, 16 bit: `Samples`, an array of shape (n,).
"""

from typing import TypeAlias

import numpy as np
import numpy.typing as npt

Samples: TypeAlias = npt.NDArray[np.int16]

SAMPLE_RATE = 16000
"""The rate that the acoustic model was trained at, Hz."""
