# SPDX-License-Identifier: Apache-2.0
"""The project's own scenes: a file each, and what they are built of."""
