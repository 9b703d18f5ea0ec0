"""One page that shows all pictures; it needs no server and no network."""

import html

from .figure import Figure

_STYLE = """
body { font: 16px/1.5 system-ui, sans-serif; max-width: 1180px; margin: 2em auto; padding: 0 1em; color: #18181c; }
img { max-width: 100%; height: auto; border: 1px solid #ddd; }
li { font-variant-numeric: tabular-nums; }
p.about { color: #555; }
"""


def page(figures: list[Figure], about: str, title: str = "multum demo") -> str:
    """The text of index.html."""
    parts = [
        "<!doctype html>",
        f'<html lang="en"><head><meta charset="utf-8"><title>{html.escape(title)}</title>',
        f"<style>{_STYLE}</style></head><body>",
        "<h1>multum</h1>",
        f'<p class="about">{html.escape(about)}</p>',
    ]
    for figure in figures:
        labels = "; ".join(panel.title for row in figure.rows for panel in row)
        parts += [
            f'<h2 id="{figure.name}">{html.escape(figure.title)}</h2>',
            f"<p>{html.escape(figure.text)}</p>",
            f'<p><img src="{figure.name}.png" alt="{html.escape(labels, quote=True)}"></p>',
        ]
        if figure.measured:
            parts += ["<ul>", *(f"<li>{html.escape(line)}</li>" for line in figure.measured), "</ul>"]
    return "\n".join([*parts, "</body></html>", ""])
