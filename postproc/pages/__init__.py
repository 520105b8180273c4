"""Pages: one HTML file each that needs no network, for a person who looks at a program, a machine,
a test or a diagnosis.

A page is blocks (tiles, sentences, tables, figures) from results that others have computed; nothing
is computed here that is not a choice of scale. `frame` puts blocks into the template, `charts`
makes figures as plain dictionaries in the form that plotly.js draws, `style` holds every colour.
The drawing library (plotly.js, from the package plotly) and the figures travel in the file,
compressed: about 2 MB, most of it the library. jinja2 is imported when a page is drawn, plotly's
Python never.
"""
