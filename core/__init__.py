"""The core: formulas, tasks, methods and what they are judged by. It knows no robot and no page.

XLA's CPU backend hands sums of products to YNNPACK; some of these fusions give wrong results
without a word in jaxlib 0.10.2 (jax-ml/jax#39103: here a schedule's windows depended on its row
in the batch). They are switched off before XLA reads its flags, at its first computation.
"""

import os

_YNNPACK = "--xla_cpu_experimental_ynn_fusion_type"

if _YNNPACK not in os.environ.get("XLA_FLAGS", ""):
    os.environ["XLA_FLAGS"] = f"{os.environ.get('XLA_FLAGS', '')} {_YNNPACK}=".strip()
