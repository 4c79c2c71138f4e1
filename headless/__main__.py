# SPDX-License-Identifier: GPL-3.0-or-later
"""``python -m headless ...`` in the source tree, ``python -m w2w.headless ...`` where W2W is installed."""

from __future__ import annotations

if __name__ == "__main__":
    from w2w.headless.start import main

    main()
