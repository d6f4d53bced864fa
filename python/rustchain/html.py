"""Views of values in notebooks, made by a package above theirs."""

from __future__ import annotations


class HtmlView:
    """Base of what notebooks show as a table and a picture."""

    def _repr_html_(self) -> str:
        """Return the view of the value for a notebook."""
        from rustchain.notebook import html_of

        return html_of(self)
